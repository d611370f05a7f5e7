# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A capture as a file: what was written is read, whatever is cut off; as a story."""

from collections.abc import Iterable
import errno
import io
import os
from pathlib import Path
import threading

from hypothesis import example, given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.link import capture
from create_oi_ros.link.capture import Capture, new_file
from create_oi_ros.oi.tools.capture_format import (
    encode_head,
    encode_record,
    FIRST_LINE,
    HEAD_LIMIT,
    Record,
    RECORD_LIMIT,
    RecordKind,
)
from create_oi_ros.oi.tools.command_line import main
from create_oi_ros.oi.tools.transcript import BYTES_SHOWN, explain_capture, GARBAGE_SHOWN
from support.captures import read, said
from support.ros import TIMEOUT

LINE = st.text(st.characters(exclude_characters='\n', exclude_categories=['Cs']))
FACTS = st.dictionaries(st.from_regex(r'[a-z][a-z0-9_]{0,9}', fullmatch=True), LINE)
BEGUN = [kind for kind in RecordKind if kind is not RecordKind.END]
PAUSE = st.one_of(st.integers(0, 20_000), st.integers(0, 2 ** 59))
RECORDS = st.lists(st.tuples(PAUSE, st.sampled_from(BEGUN), st.binary(max_size=300)), max_size=12)
SECOND = 1_000_000


def written(facts: dict[str, str], parts: Iterable[tuple[int, RecordKind, bytes]]) -> bytes:
    """Return the bytes of a file whose end is not written yet."""
    return encode_head(facts) + b''.join(encode_record(*part) for part in parts)


def timed(parts: Iterable[tuple[int, RecordKind, bytes]]) -> list[Record]:
    """Return what is to be read."""
    now, records = 0, []
    for pause, kind, data in parts:
        now += pause
        records.append(Record(now, kind, data))
    return records


@given(FACTS, RECORDS, st.integers(1, 50))
@example({}, [], 1)
def test_what_was_written_is_read(
        facts: dict[str, str], parts: list[tuple[int, RecordKind, bytes]], size: int) -> None:
    ended = [*parts, (1, RecordKind.END, b'')]
    assert read(written(facts, ended), size) == (facts, timed(ended), '')


@given(FACTS, RECORDS, st.data())
def test_a_file_cut_anywhere_is_read_up_to_the_cut(
        facts: dict[str, str], parts: list[tuple[int, RecordKind, bytes]],
        data: st.DataObject) -> None:
    whole = written(facts, [*parts, (1, RecordKind.END, b'')])
    head = len(encode_head(facts))
    cut = data.draw(st.integers(0, len(whole) - 1))
    found, records, wrong = read(whole[:cut])
    assert found == (facts if cut >= head else None)
    assert records == timed(parts)[:len(records)]
    kept = len(written(facts, parts[:len(records)]))
    assert cut < head or len(records) == len(parts) or cut < kept + len(
        encode_record(*parts[len(records)]))
    assert wrong.startswith('cut short at ' if cut else 'empty')


@given(st.binary())
def test_any_bytes_are_read_or_refused_in_words(data: bytes) -> None:
    assert read(data)[2]
    read(encode_head({}) + data, 3)


def test_the_format_is_as_described() -> None:
    assert written({'port': '/dev/create'}, [
        (5, RecordKind.TO_ROBOT, b'\x80'), (20, RecordKind.FROM_ROBOT, b'\1\2'),
        (0, RecordKind.END, b'')]) == (
            b'create capture 1\nport /dev/create\n\n'
            b'\x29\x01\x80' b'\xa0\x01\x02\x01\x02' b'\x06\x00')


@pytest.mark.parametrize('data, words', [
    (b'\x89PNG', 'no capture'),
    (b'create capture 2\nport x\n\n', 'version 2; this program reads version 1'),
    (FIRST_LINE + bytes(HEAD_LIMIT), 'its head has no end'),
    (written({}, [(0, RecordKind.END, b''), (0, RecordKind.NOTE, b'')]), 'bytes follow its end'),
    (encode_head({}) + b'\7\0', 'damaged at byte 18'),
    (encode_head({}) + b'\0' + b'\xff\xff\xff\x01', 'damaged at byte 18'),
    (encode_head({}) + b'\0\0' + b'\xff' * 9, 'damaged at byte 20'),
])
def test_what_is_no_capture_is_told_from_a_damaged_one(data: bytes, words: str) -> None:
    assert words in read(data)[2]


@pytest.mark.parametrize('facts', [{'Port': ''}, {'': 'x'}, {'port': 'a\nb'}])
def test_a_fact_is_a_name_and_a_line(facts: dict[str, str]) -> None:
    with pytest.raises(ValueError, match='one line'):
        encode_head(facts)


@pytest.mark.parametrize('pause, size', [(-1, 0), (0, RECORD_LIMIT + 1)])
def test_a_record_that_could_not_be_read_is_not_written(pause: int, size: int) -> None:
    with pytest.raises(ValueError, match='allowed'):
        encode_record(pause, RecordKind.NOTE, bytes(size))


# As a story.

LIST = oi.PacketList(['bumps_and_wheel_drops', 'distance', 'voltage', 'cliff_left_signal'])
ASK = oi.Stream(packets=LIST.ids).encode()


def frame(bumps: int = 0, distance: int = 0, signal: int = 0) -> bytes:
    """Return a frame of the list."""
    return LIST.pack_frame([bumps, distance, 15000, signal])


def story(*records: tuple[float, RecordKind, bytes], everything: bool = False) -> list[str]:
    """Return what is told of records at times in seconds, without the spaces in front."""
    return [line.strip() for line in explain_capture(
        (Record(round(time * SECOND), kind, data) for time, kind, data in records),
        everything=everything)]


QUIET = [
    (1 + at * 0.015, RecordKind.FROM_ROBOT, frame(distance=3, signal=at)) for at in range(100)]


def test_a_quiet_time_is_a_sum() -> None:
    told = story((0.0, RecordKind.OPENED, b'/dev/x at 57600 baud'),
                 (0.9, RecordKind.TO_ROBOT, ASK), *QUIET,
                 (2.6, RecordKind.FROM_ROBOT, frame(bumps=1)), (2.7, RecordKind.TO_ROBOT, ASK),
                 (2.8, RecordKind.END, b''))
    assert told == [
        '0.000 -- port opened: /dev/x at 57600 baud',
        '0.900 -> Stream packets=7,19,22,28',
        '1.000 -- checksums include the header, as real robots do',
        '1.000 <- Bumps and Wheel Drops = 0',
        '2.600 <- Bumps and Wheel Drops = bump_right',
        '2.800 -- 101 frames in 2.8 s, Distance = 300 mm, Voltage = 15000 mV, '
        'Stream sent again 1 times',
        '2.800 -- end of the capture']


def test_a_long_time_is_summed_up_in_pieces() -> None:
    minute = [(at * 0.1, RecordKind.FROM_ROBOT, frame(distance=1)) for at in range(600)]
    told = story((0.0, RecordKind.TO_ROBOT, ASK), *minute, (60.0, RecordKind.LOST, b'unplugged'))
    assert told[3:5] == [
        '10.000 -- 101 frames in 10.0 s, Distance = 101 mm, Voltage = 15000 mV',
        '20.000 -- 100 frames in 10.0 s, Distance = 100 mm, Voltage = 15000 mV']
    assert told[-1] == '60.000 -- port lost: unplugged'


def test_speeds_are_told_when_they_change() -> None:
    go, halt = (oi.DriveDirect(right=v, left=v).encode() for v in (100, 0))
    told = story((1, RecordKind.TO_ROBOT, go), (2, RecordKind.TO_ROBOT, go),
                 (3, RecordKind.TO_ROBOT, halt),
                 (4, RecordKind.TO_ROBOT, go), (5, RecordKind.TO_ROBOT, oi.Safe().encode() * 2))
    assert [line.split(maxsplit=1)[1] for line in told] == [
        '-> Drive Direct right=100 left=100', '-> Drive Direct right=0 left=0',
        '-> Drive Direct right=100 left=100', '-> Safe', '-> Safe']


def test_silence_garbage_and_a_lost_port_are_told() -> None:
    told = story(
        (0, RecordKind.TO_ROBOT, bytes(30) + ASK), (1, RecordKind.FROM_ROBOT, frame()),
        (2, RecordKind.FROM_ROBOT, b'\7RDK by iRobot!' + frame()[:6]),
        (3, RecordKind.TO_ROBOT, b'\x89'),
        (4, RecordKind.LOST, b'gone'), (5, RecordKind.BAUD, b'19200'),
        (6, RecordKind.NOTE, b'info: hello'))
    assert told == [
        f'0.000 -> no command:{" 0" * BYTES_SHOWN} ... (30 bytes)',
        '0.000 -> Stream packets=7,19,22,28',
        '1.000 -- checksums include the header, as real robots do',
        '1.000 <- Bumps and Wheel Drops = 0',
        '2.000 -- silence of the robot, 1.000 s',
        "4.000 <- no frame: 7 82 68 75 32 98 121 32 105 82 111 98 111 116 33 19 11 7 0 19 0 "
        "'RDK by iRobot!'",
        '4.000 -> Drive is cut short: 137',
        '4.000 -- 1 frames in 4.0 s, Distance = 0 mm, Voltage = 15000 mV, '
        '1 pieces of garbage (21 bytes)',
        '4.000 -- port lost: gone',
        '5.000 -- host speaks at baud rate 19200',
        '6.000 -- driver says info: hello']


def test_a_bad_line_can_still_be_read() -> None:
    damaged = frame()[:-1] + b'\0'
    bad = [(1 + at * 0.015, RecordKind.FROM_ROBOT, damaged + frame()) for at in range(100)]
    records = ((0, RecordKind.TO_ROBOT, ASK), (0.9, RecordKind.FROM_ROBOT, frame()), *bad,
               (3, RecordKind.END, b''))
    told = story(*records)
    assert len(told) == 3 + GARBAGE_SHOWN + 2
    assert told[3] == '1.000 <- checksum is wrong: 19 11 7 0 19 0 0 22 58 152 28 0 0 0'
    assert told[-2].endswith('100 pieces of garbage (1400 bytes)')
    assert len([line for line in story(*records, everything=True) if 'wrong' in line]) == 100


def test_a_list_that_no_robot_knows_is_told_and_not_waited_for() -> None:
    told = story((0, RecordKind.TO_ROBOT, bytes([148, 1, 43]) + ASK),
                 (1, RecordKind.FROM_ROBOT, frame()), (2, RecordKind.END, b''))
    assert told[0].startswith('0.000 -> # Stream packets=43 (out of range')
    assert not any('no frame' in line for line in told)


# At the door.

def door(path: Path, *arguments: str) -> tuple[int, list[str], str]:
    """Return exit code, lines and complaint of `decode --capture`."""
    out, err = io.StringIO(), io.StringIO()
    status = main(['decode', '--capture', str(path), *arguments], io.StringIO(), out, err)
    return status, out.getvalue().splitlines(), err.getvalue().strip()


def test_a_file_is_explained(tmp_path: Path) -> None:
    path = tmp_path / 'walk.capture'
    data = written({'port': '/dev/create'}, [
        (0, RecordKind.OPENED, b'/dev/create'), (1000, RecordKind.TO_ROBOT, b'\x83'),
        (500, RecordKind.END, b'')])
    path.write_bytes(data)
    assert door(path) == (0, [
        'port = /dev/create', '      0.000 -- port opened: /dev/create', '      0.001 -> Safe',
        '      0.002 -- end of the capture'], '')
    assert '# 131. Enter Safe mode' in door(path, '--explain')[1][2]
    path.write_bytes(data[:-1])
    status, lines, complaint = door(path, '--all')
    assert status == 1 and lines[-1] == '      0.001 -> Safe'
    assert complaint.startswith(f'{path}: cut short at 0.001 s')


# As it is written.


def test_what_is_added_is_in_the_file_up_to_its_end(tmp_path: Path) -> None:
    (tmp_path / 'c').touch()  # and is kept
    ours = Capture(str(tmp_path / 'c'), {}, print)
    assert ours.path == tmp_path / 'c-2'
    ours.add(RecordKind.OPENED, '/dev/x at 57600 baud')
    ours.add(RecordKind.TO_ROBOT, b'\x80')
    ours.add(RecordKind.LOST, '\udcff' * RECORD_LIMIT)
    ours.close()
    ours.add(RecordKind.NOTE, 'too late')
    _, records, wrong = read(ours.path.read_bytes())
    assert not wrong
    assert [(record.kind, record.data) for record in records] == [
        (RecordKind.OPENED, b'/dev/x at 57600 baud'), (RecordKind.TO_ROBOT, b'\x80'),
        (RecordKind.LOST, (b'\\udcff' * RECORD_LIMIT)[:RECORD_LIMIT]), (RecordKind.END, b'')]


def writing_thread() -> threading.Thread | None:
    """Return the thread that writes a capture."""
    return next((each for each in threading.enumerate() if each.name == 'create_capture'), None)


def test_a_full_disk_ends_the_capture_and_nothing_else(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full, write, told = threading.Event(), os.write, []

    def full_write(file: int, data: bytes) -> int:
        if threading.current_thread() is writing_thread():
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(file, data)

    def on_failure(why: str) -> None:
        told.append(why)
        full.set()
    ours = Capture(str(tmp_path / 'c'), {}, on_failure)
    monkeypatch.setattr(os, 'write', full_write)
    ours.add(RecordKind.NOTE, 'too much')
    assert full.wait(TIMEOUT)
    ours.add(RecordKind.FROM_ROBOT, b'\0')
    ours.close()
    assert told == ['No space left on device; nothing more is captured, the driver goes on']


def test_while_a_disk_hangs_records_are_dropped_counted_and_said(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(capture, 'WRITE_INTERVAL', 0.0)
    monkeypatch.setattr(capture, 'PENDING_LIMIT', 2000)
    hangs, goes_on, write, told = threading.Event(), threading.Event(), os.write, []

    def hanging_write(file: int, data: bytes) -> int:
        if threading.current_thread() is writing_thread():
            hangs.set()
            assert goes_on.wait(TIMEOUT)
        return write(file, data)
    monkeypatch.setattr(os, 'write', hanging_write)
    ours = Capture(str(tmp_path / 'c'), {}, told.append)
    ours.add(RecordKind.FROM_ROBOT, b'first')
    assert hangs.wait(TIMEOUT)
    for _ in range(100):
        ours.add(RecordKind.FROM_ROBOT, bytes(100))
    monkeypatch.setattr(capture, 'CLOSE_TIMEOUT', 0.0)
    ours.close()
    writing = writing_thread()
    goes_on.set()
    assert writing is not None
    writing.join(TIMEOUT)
    _, records, wrong = read(ours.path.read_bytes())
    dropped = 100 - len(said(records)[len(b'first'):]) // 100
    assert not wrong and dropped > 75
    assert records[-2].text == f'{dropped} records were dropped: the disk took no bytes'
    assert told == ['the disk takes no bytes; records are dropped until it does',
                    records[-2].text, 'the disk takes no bytes; the end is not written']


def test_a_home_is_found_and_nothing_overwritten(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('HOME', str(tmp_path))
    names = []
    for _ in range(3):
        file, path = new_file('~/walk.capture')
        os.close(file)
        names.append(path)
    assert names == [tmp_path / f'walk{number}.capture' for number in ('', '-2', '-3')]


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError, match='give a file'):
        new_file(str(tmp_path))
