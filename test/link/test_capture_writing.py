# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A capture as it is written: the port and the file alone, without a node."""

import os
from pathlib import Path
import threading

import pytest

from create_oi_ros.link import capture
from create_oi_ros.link.capture import begin, Capture, CapturedPort, new_file
from create_oi_ros.link.port import PortError
from create_oi_ros.oi.tools.capture_format import RecordKind
from support.captures import read, said
from support.ros import TIMEOUT


def test_bytes_of_both_directions_are_captured_in_order(tmp_path: Path) -> None:
    robot, host = os.openpty()
    ours, path = begin(str(tmp_path / 'c'), {}, print)
    name = os.ttyname(host)
    port = CapturedPort(ours, name, 57600, timeout=TIMEOUT)
    os.close(host)
    port.baud = 19200
    port.write(b'\x80')
    assert os.read(robot, 1) == b'\x80'
    os.write(robot, b'hello')
    heard = b''
    while heard != b'hello':
        heard += port.read()
    os.close(robot)
    for _ in range(2):
        with pytest.raises(PortError):
            port.read()
    with pytest.raises(PortError):
        port.write(b'\x83')
    ours.close()
    ours.add_text(RecordKind.NOTE, 'too late')
    records, wrong = read(path)
    assert not wrong
    told = [(record.kind, record.text) for record in records if record.kind in (
        RecordKind.OPENED, RecordKind.BAUD)]
    assert told == [(RecordKind.OPENED, f'{name} at 57600 baud'), (RecordKind.BAUD, '19200')]
    assert said(records) == b'hello' and said(records, RecordKind.TO_ROBOT) == b'\x80\x83'
    assert [record.kind for record in records].count(RecordKind.LOST) == 1
    assert records[-1].kind is RecordKind.END


def test_a_full_disk_ends_the_capture_and_nothing_else(tmp_path: Path) -> None:
    full, told = threading.Event(), []

    def on_failure(why: str) -> None:
        told.append(why)
        full.set()
    file, _ = new_file(str(tmp_path / 'c'))
    ours = Capture(file, {}, on_failure)
    disk = os.open('/dev/full', os.O_WRONLY)
    os.dup2(disk, file)
    os.close(disk)
    ours.add_text(RecordKind.NOTE, 'too much')
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
        if threading.current_thread().name == 'create_capture':
            hangs.set()
            assert goes_on.wait(TIMEOUT)
        return write(file, data)
    monkeypatch.setattr(os, 'write', hanging_write)
    file, path = new_file(str(tmp_path / 'c'))
    ours = Capture(file, {}, told.append)
    ours.add(RecordKind.FROM_ROBOT, b'first')
    assert hangs.wait(TIMEOUT)
    for _ in range(100):
        ours.add(RecordKind.FROM_ROBOT, bytes(100))
    assert len(ours._pending) < 2200
    monkeypatch.setattr(capture, 'CLOSE_TIMEOUT', 0.0)
    ours.close()
    goes_on.set()
    ours._thread.join(TIMEOUT)
    records, wrong = read(path)
    dropped = 100 - len(said(records)[len(b'first'):]) // 100
    assert not wrong and dropped > 75
    assert records[-2].text == f'{dropped} records were dropped: the disk took no bytes'
    assert told == ['the disk takes no bytes; records are dropped until it does',
                    records[-2].text, 'the disk takes no bytes; the end is not written']


def test_a_disk_that_is_full_from_the_beginning_is_refused() -> None:
    with pytest.raises(OSError, match='No space'):
        Capture(os.open('/dev/full', os.O_WRONLY), {}, print)


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
