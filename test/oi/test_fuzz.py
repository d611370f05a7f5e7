# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Mutated frames against the stream reader.

Whatever is done to the bytes of good frames, and however the bytes are cut into pieces, the
reader must

- raise nothing;
- return every byte once, in order;
- call bytes a frame only if header, length, ids and checksum are those of a list it expects;
- return the same events for any other way to cut the bytes;
- find every good frame. The one exception: half a frame and the bytes after it can by chance
  look like a frame, and a good frame that begins inside is lost.
"""

from collections.abc import Iterator
from random import Random

import pytest

from create_oi_ros import oi
from support.nightly import NIGHTLY, times

LISTS = [
    oi.PacketList([29, 13]), oi.PacketList([30, 13]), oi.PacketList([19, 20, 35]),
    oi.PacketList([19]), oi.PacketList([*range(7, 15), *range(17, 38), *range(39, 43)]),
    oi.PacketList([6]),
]
BANNER = b'bl-start\r\n2004-11-17-1529-L  \r\nRDK by iRobot!\r\nMC9S12E128\r\n'
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


def events(data: bytes, lists: list[oi.PacketList], step: int) -> Iterator[oi.Frame | oi.Garbage]:
    """Yield what the reader finds in bytes that are cut into pieces of `step` bytes."""
    reader = oi.StreamReader(lists)
    for start in range(0, len(data), step):
        reader.feed(data[start:start + step])
        while (found := reader.next_event()) is not None:
            yield found
    yield from reader.finish()


def check(pieces: list[tuple[bytes, bool]], lists: list[oi.PacketList], step: int) -> int:
    """Check one run of pieces, each with whether it is a good frame; return the frames found."""
    data = b''.join(piece for piece, _ in pieces)
    found = list(events(data, lists, step))
    assert found == list(events(data, lists, len(data) + 1)), 'cutting changed the events'
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
