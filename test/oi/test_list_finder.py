# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which lists of packets a robot streams, found from its bytes alone."""

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.oi.tools.explain import ListFinder
from support.oi_strategies import frames, packet_lists

CLIFF = oi.PacketList([29, 13])
GOOD = CLIFF.pack_frame([549, 0])


def lists_in(data: bytes) -> list[oi.PacketList]:
    """Return the lists of packets whose frames are in these bytes, in order of appearance."""
    finder = ListFinder()
    finder.feed(data)
    finder.finish()
    return list(finder.lists)


@given(packet_lists().flatmap(lambda packets: st.tuples(
    st.just(packets), st.lists(frames(packets), min_size=1, max_size=3))))
def test_a_list_is_found_in_its_frames(drawn: tuple[oi.PacketList, list[bytes]]) -> None:
    packets, data = drawn
    assert lists_in(b''.join(data)) == [packets]


def test_lists_are_found_behind_noise_and_however_the_bytes_are_split() -> None:
    other = oi.PacketList(['distance', 1])
    data = b'\x13\xff\x13\0' + GOOD + b'\x13\5\x1d' + other.pack_frame([19] * 11) + b'\x13\5\x1d'
    assert lists_in(data) == [CLIFF, other]
    finder = ListFinder()
    ready = b''.join(finder.feed(bytes([byte])) for byte in data)
    assert ready + finder.finish() == data
    assert list(finder.lists) == [CLIFF, other]


@pytest.mark.parametrize('data', [
    b'', b'\x13', b'\x13\5\xff', GOOD[:-1], GOOD[:-1] + b'\0',
    b'\x13\2\7\0\7\0', b'\x13\1\7\0', b'\x13\0\xed'])
def test_no_list_is_found_where_no_frame_is(data: bytes) -> None:
    assert lists_in(data) == []
