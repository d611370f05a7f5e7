# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the reader of streams changes its mind: the longest frame, the third frame in a row."""

from create_oi_ros import oi

PACKETS = oi.PacketList([7])


def frame(total: int) -> bytes:
    """Return a frame whose bytes have this sum."""
    body = bytes([oi.HEADER, PACKETS.length, 7, 0])
    return body + bytes([(total - sum(body)) & 0xff])


def test_the_longest_frame_is_expected_and_found():
    longest = [oi.PacketList([6] * groups + [7] * bits) for groups in range(6)
               for bits in range(130)]
    packets = next(each for each in longest if each.frame_size == oi.FRAME_LIMIT)
    reader = oi.StreamReader([packets])
    body = bytes([oi.HEADER, packets.length]) + b''.join(
        bytes([number]) + bytes(oi.size_of(number)) for number in packets.ids)
    reader.feed(body + bytes([-sum(body) & 0xff]))
    assert isinstance(reader.next_event(), oi.Frame)


def test_after_a_damaged_frame_three_in_a_row_still_change_the_convention():
    reader = oi.StreamReader([PACKETS])
    reader.feed(frame(0) + frame(1) + frame(oi.HEADER) * 3)
    found = list(iter(reader.next_event, None))
    assert [event.checksum for event in found if isinstance(event, oi.Frame)] == [
        oi.Checksum.HARDWARE, oi.Checksum.MANUAL]


def test_empty_and_too_long_lists_are_ignored():
    reader = oi.StreamReader([oi.PacketList([]), oi.PacketList([6] * 5)])
    reader.feed(bytes([oi.HEADER, 0, 256 - oi.HEADER]))
    assert reader.finish() == [oi.Garbage(bytes([oi.HEADER, 0, 256 - oi.HEADER]))]
