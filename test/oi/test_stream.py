# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Finding frames and commands: however the bytes are split, the same events; no byte is lost."""

from collections.abc import Iterable
from random import Random
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.oi.stream import FRAMES_TO_SWITCH, GARBAGE_LIMIT
from support.nightly import NIGHTLY, times
from support.oi_strategies import commands

CLIFF = oi.PacketList([29, 13])
GOOD = CLIFF.pack_frame([549, 0])
BY_THE_MANUAL = CLIFF.pack_frame([549, 0], header_in_sum=False)
BANNER = (
    b'bl-start\r\n2004-11-17-1529-L  \r\nRDK by iRobot!\r\nMC9S12E128\r\n2004-11-22-1441-L  \r\n'
    b'battery-current-zero 257\r\n\r\nassembly 2004-11-22-1443-L  \r\n')
Event = oi.Frame | oi.Garbage


def events(
        chunks: Iterable[bytes], *lists: oi.PacketList, reader: oi.StreamReader | None = None,
) -> list[Event]:
    """Feed the chunks and finish; return all events."""
    reader = reader or oi.StreamReader(lists)
    found: list[Event] = []
    for chunk in chunks:
        reader.feed(chunk)
        found.extend(reader)
    return found + reader.finish()


def bytewise(data: bytes) -> list[bytes]:
    return [data[place:place + 1] for place in range(len(data))]


def kinds(found: Iterable[Event]) -> str:
    return ''.join('F' if isinstance(event, oi.Frame) else 'g' for event in found)


def test_a_failed_checksum_is_counted_once() -> None:
    reader = oi.StreamReader([CLIFF])
    events(bytewise(GOOD + GOOD[:-1] + b'\0' + GOOD), reader=reader)
    assert reader.checksum_failures == 1


def test_only_frames_that_were_asked_for_are_frames() -> None:
    assert events([GOOD]) == [oi.Garbage(GOOD)]
    assert events([GOOD], oi.PacketList([30, 13])) == [oi.Garbage(GOOD)]
    assert events([GOOD], oi.PacketList([])) == [oi.Garbage(GOOD)]


def test_the_list_may_change_in_flight() -> None:
    longer = oi.PacketList([7, 29, 13])
    late = longer.pack_frame([1, 2, 0])
    reader = oi.StreamReader([CLIFF])
    reader.feed(GOOD + GOOD[:3])
    assert kinds(list(reader)) == 'F'
    reader.expect([CLIFF, longer])
    reader.feed(GOOD[3:] + late + late[:5])
    assert [e.packets for e in list(reader) if isinstance(e, oi.Frame)] == [CLIFF, longer]
    reader.expect([longer])
    reader.feed(late[5:] + GOOD)
    assert [e.packets for e in list(reader) if isinstance(e, oi.Frame)] == [longer]


def test_a_list_too_long_for_a_frame_is_ignored() -> None:
    packets = oi.PacketList([6] * 5)
    assert packets.length == (5 * 53) & 0xff
    with pytest.raises(ValueError, match='up to 258'):
        packets.pack_frame([0] * 180)
    looks_like_it = bytes([oi.HEADER, packets.length]) + packets.pack_reply([0] * 180)
    assert kinds(events([looks_like_it], packets)) == 'gg'


def test_the_checksum_convention_is_kept_until_the_other_repeats() -> None:
    reader = oi.StreamReader([CLIFF])
    assert reader.checksum is None
    assert kinds(events([GOOD], reader=reader)) == 'F'
    assert reader.checksum is oi.Checksum.HARDWARE
    assert kinds(events([BY_THE_MANUAL + GOOD] * FRAMES_TO_SWITCH, reader=reader)) == 'gF' * 3
    assert reader.checksum_failures == FRAMES_TO_SWITCH
    found = events([BY_THE_MANUAL * (FRAMES_TO_SWITCH + 1)], reader=reader)
    assert kinds(found) == 'gFF'
    assert reader.checksum is oi.Checksum.MANUAL
    assert reader.checksum_failures == 2 * FRAMES_TO_SWITCH - 1
    assert kinds(events([GOOD], reader=reader)) == 'g'


def test_after_a_damaged_frame_three_in_a_row_still_change_the_convention() -> None:
    damaged = GOOD[:-1] + bytes([GOOD[-1] + 1 & 0xff])
    found = events([GOOD + damaged + BY_THE_MANUAL * FRAMES_TO_SWITCH], CLIFF)
    assert [event.checksum for event in found if isinstance(event, oi.Frame)] == [
        oi.Checksum.HARDWARE, oi.Checksum.MANUAL]


def test_the_boot_banner_is_reported_and_readable_in_two_pieces() -> None:
    for chunks in ([BANNER + GOOD], bytewise(BANNER + GOOD)):
        garbage, frame = events(chunks, CLIFF)
        assert isinstance(garbage, oi.Garbage)
        assert garbage.data == BANNER and garbage.text == BANNER.decode().strip()
        assert isinstance(frame, oi.Frame)
    found = events([bytes(GARBAGE_LIMIT - 33) + BANNER + GOOD], CLIFF)
    assert kinds(found) == 'ggF'
    assert oi.Garbage(found[0].data + found[1].data).text == BANNER.decode().strip()


def test_noise_is_not_text() -> None:
    assert oi.Garbage(bytes(range(20)) + b'bad\0 \r\n\r\n \n\r \0').text == ''
    assert oi.Garbage(b'').text == ''
    banner = oi.Garbage(b'\xffRDK by iRobot!\xff\0battery 257\r\n')
    assert banner.text == 'RDK by iRobot!\nbattery 257'


def commands_in(chunks: Iterable[bytes]) -> tuple[list[oi.Command | oi.UnknownOpcode], bytes]:
    reader = oi.CommandReader()
    found = []
    for chunk in chunks:
        reader.feed(chunk)
        while (event := reader.next_event()) is not None:
            found.append(event)
    return found, reader.clear()


@given(st.lists(commands(), max_size=10), st.lists(st.integers(0), max_size=20))
def test_commands_in_order_come_out_in_order(
        sent: list[oi.Command], places: list[int]) -> None:
    data = b''.join(command.encode() for command in sent)
    marks = sorted({0, len(data), *(place % (len(data) + 1) for place in places)})
    cuts = [data[start:end] for start, end in zip(marks, marks[1:])]
    assert commands_in(cuts) == (sent, b'')


def test_an_unknown_opcode_is_one_byte() -> None:
    assert commands_in([bytes([7, 133, 146, 128])]) == (
        [oi.UnknownOpcode(b'\7'), oi.UnknownOpcode(b'\x85'), oi.UnknownOpcode(b'\x92'),
         oi.Start()], b'')


@pytest.mark.parametrize('lists, message', [
    (CLIFF, r'expected a list of lists, not one list: write \[PacketList\(\(29, 13\)\)\]'),
    ([(29, 13)], r'expected lists of the class PacketList, not \(29, 13\)'),
    ((29, 13), 'expected lists of the class PacketList, not 29')])
def test_a_reader_refuses_what_is_no_list_of_packet_lists(lists: Any, message: str) -> None:
    with pytest.raises(TypeError, match=message):
        oi.StreamReader(lists)
    reader = oi.StreamReader([CLIFF])
    with pytest.raises(TypeError, match=message):
        reader.expect(lists)


# Damaged frames, at random.


LISTS = [
    oi.PacketList([29, 13]), oi.PacketList([30, 13]), oi.PacketList([19, 20, 35]),
    oi.PacketList([19]), oi.PacketList([*range(7, 15), *range(17, 38), *range(39, 43)]),
    oi.PacketList([6]),
]
FRAMES_AT_ONCE = 40


def good_frame(packets: oi.PacketList, random: Random) -> bytes:
    """Return a frame; every second one is full of bytes that look like headers and ids."""
    size = packets.reply_size
    if random.random() < 0.5:
        reply = bytes(random.choices([oi.HEADER, packets.length, *packets.ids], k=size))
    else:
        reply = random.randbytes(size)
    body = bytearray([oi.HEADER, packets.length])
    place = 0
    for number in packets.ids:
        step = oi.size_of(number)
        body += bytes([number]) + reply[place:place + step]
        place += step
    return bytes(body) + bytes([-sum(body) & 0xff])


def mutated(frame: bytes, random: Random) -> bytes:
    """Return the frame with a flipped bit, cut, doubled, or with bytes or text inserted."""
    place = random.randrange(len(frame))
    match random.randrange(6):
        case 0:
            flipped = frame[place] ^ 1 << random.randrange(8)
            return frame[:place] + bytes([flipped]) + frame[place + 1:]
        case 1:
            return frame[:place]
        case 2:
            return frame[place:]
        case 3:
            return frame[:place] + random.randbytes(random.randrange(4)) + frame[place:]
        case 4:
            return frame[:place] + frame
        case _:
            return frame[:place] + BANNER * random.randrange(6)


def check(pieces: list[tuple[bytes, bool]], lists: list[oi.PacketList], step: int) -> int:
    """
    Check one run of pieces, each with whether it is a good frame; return the frames found.

    However the bytes are cut, the events are the same, hold every byte once and in order, and are
    frames only if header, length, ids and checksum are those of a list. Every good frame is
    found, with one exception: half a frame and the bytes after it can by chance look like a
    frame, and a good frame that begins inside is lost.
    """
    data = b''.join(piece for piece, _ in pieces)
    found = events([data[at:at + step] for at in range(0, len(data), step)], *lists)
    assert found == events([data], *lists), 'cutting changed the events'
    assert b''.join(event.data for event in found) == data, 'bytes lost or changed'
    covered: set[int] = set()
    place = 0
    for event in found:
        if isinstance(event, oi.Frame):
            assert event.packets in lists and event.packets.matches(event.data)
            assert len(event.data) == event.packets.frame_size
            total = {oi.Checksum.HARDWARE: 0, oi.Checksum.MANUAL: oi.HEADER}[event.checksum]
            assert sum(event.data) % 256 == total, 'a checksum is wrong'
            assert event.readings.has(*event.packets.names)
            covered.update(range(place, place + len(event.data)))
        place += len(event.data)
    frames = [event for event in found if isinstance(event, oi.Frame)]
    # Three damaged frames in a row can look like the other checksum rule: rare, and no fault.
    if all(frame.checksum is oi.Checksum.HARDWARE for frame in frames):
        assert not missed(pieces, covered), 'a good frame was not found'
    return len(frames)


def missed(pieces: list[tuple[bytes, bool]], covered: set[int]) -> list[int]:
    """Return where good frames begin of which no byte is in a found frame."""
    starts, place = [], 0
    for piece, good in pieces:
        if good and covered.isdisjoint(range(place, place + len(piece))):
            starts.append(place)
        place += len(piece)
    return starts


@pytest.mark.timeout(3600)
@pytest.mark.parametrize(('count', 'seed'), [
    (4000, 2), pytest.param(times(1_000_000), 1, marks=NIGHTLY)])
def test_damaged_frames_are_found_out_and_good_ones_found(count, seed):
    random, found = Random(seed), 0
    for _ in range(0, count, FRAMES_AT_ONCE):
        lists = random.sample(LISTS, random.randrange(1, 4))
        # The first frame is good: from it the reader learns the checksum rule.
        frames = [(good_frame(lists[0], random), True)]
        mutated_share = random.random()
        while len(frames) < FRAMES_AT_ONCE:
            frame = good_frame(random.choice(lists), random)
            good = random.random() > mutated_share
            frames.append((frame if good else mutated(frame, random), good))
        found += check(frames, lists, random.randrange(1, 40))
    assert found > count / 2
