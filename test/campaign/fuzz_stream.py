"""
Mutated frames against the stream reader: `make fuzz ARGS='[COUNT [SEED]]'`.

The invariant: whatever is done to the bytes of good frames and however they are cut, the reader
raises nothing, gives back every byte once and in order, calls a frame only what has the header,
length, ids and checksum of a list it expects, does so alike for another cutting, and finds every
good frame but those that chance made part of another: half a frame and what follows it.
"""

from collections.abc import Iterator
from random import Random
import sys
from time import perf_counter

from create_oi_ros import oi

LISTS = [
    oi.PacketList([29, 13]), oi.PacketList([30, 13]), oi.PacketList([19, 20, 35]),
    oi.PacketList([19]), oi.PacketList([*range(7, 15), *range(17, 38), *range(39, 43)]),
    oi.PacketList([6]),
]
BANNER = b'bl-start\r\n2004-11-17-1529-L  \r\nRDK by iRobot!\r\nMC9S12E128\r\n'
FRAMES_AT_ONCE = 40


def good_frame(packets: oi.PacketList, random: Random) -> bytes:
    """Return a frame; half of them are full of bytes that look like headers and ids."""
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
    """Return the frame flipped, cut, stretched, doubled or drowned in text."""
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
    """Read bytes cut into pieces of a size."""
    reader = oi.StreamReader(lists)
    for start in range(0, len(data), step):
        reader.feed(data[start:start + step])
        while (found := reader.next_event()) is not None:
            yield found
    yield from reader.finish()


def check(pieces: list[tuple[bytes, bool]], lists: list[oi.PacketList], step: int) -> int:
    """Hold the reader to the invariant for pieces, good or not; return the frames found."""
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
    # Three damaged frames in a row can look like the other convention: rare, and no fault.
    if all(frame.checksum is oi.Checksum.HARDWARE for frame in frames):
        assert not missed(pieces, covered), 'a good frame was not found'
    return len(frames)


def missed(pieces: list[tuple[bytes, bool]], covered: set[int]) -> list[int]:
    """Return where good frames begin of which no byte lies in a frame that was delivered."""
    starts, place = [], 0
    for piece, good in pieces:
        if good and covered.isdisjoint(range(place, place + len(piece))):
            starts.append(place)
        place += len(piece)
    return starts


def main(count: int = 1_000_000, seed: int = 1) -> None:
    """Run so many frames, half of them mutated."""
    random = Random(seed)
    began = perf_counter()
    found = 0
    for _ in range(0, count, FRAMES_AT_ONCE):
        lists = random.sample(LISTS, random.randrange(1, 4))
        # The first frame is good: it decides what the checksum is a sum of.
        frames = [(good_frame(lists[0], random), True)]
        trouble = random.random()
        while len(frames) < FRAMES_AT_ONCE:
            frame = good_frame(random.choice(lists), random)
            good = random.random() > trouble
            frames.append((frame if good else mutated(frame, random), good))
        found += check(frames, lists, random.randrange(1, 40))
    print(f'{count} frames, seed {seed}: {found} delivered, none wrong, none missed; '
          f'{perf_counter() - began:.0f} s')


if __name__ == '__main__':
    main(*map(int, sys.argv[1:]))
