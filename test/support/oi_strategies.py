# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Strategies of hypothesis for commands, lists of packets and frames."""

from collections.abc import Iterable
from typing import Any

from hypothesis import strategies as st

from create_oi_ros import oi
from create_oi_ros.oi.wire import Wire


def numbers(wire: Wire) -> st.SearchStrategy[int]:
    allowed = st.integers(wire.low, wire.high).filter(wire.allows)
    if wire.names:
        allowed |= st.sampled_from(list(wire.names)).filter(wire.allows)
    return allowed


def fields(kind: type[oi.Command]) -> st.SearchStrategy[dict[str, Any]]:
    values: dict[str, st.SearchStrategy[Any]] = {
        field.name: numbers(field.wire) for field in kind.fields}
    if kind.tail is not None:
        _, counted, item = kind.tail
        count = {'min_size': counted.low, 'max_size': counted.high}
        if item is bytes:
            values[kind.tail.name] = st.binary(**count)
        else:
            one = [numbers(wire) for wire in counted.item]
            items = one[0] if len(one) == 1 else st.builds(item, *one)
            values[kind.tail.name] = st.lists(items, **count).map(tuple)
    return st.fixed_dictionaries(values)


def commands(kinds: Iterable[type[oi.Command]] = oi.COMMANDS) -> st.SearchStrategy[oi.Command]:
    """Draw commands whose values are in range."""
    return st.one_of([fields(kind).map(lambda values, kind=kind: kind(**values))
                      for kind in kinds])


def packet_lists(max_size: int = 12) -> st.SearchStrategy[oi.PacketList]:
    """Draw lists of single packets and groups that fit in a frame."""
    lists = st.lists(st.sampled_from([*oi.GROUPS, *oi.PACKETS]), min_size=1, max_size=max_size)
    return lists.map(oi.PacketList).filter(lambda packets: packets.frame_size <= 258)


@st.composite
def frames(draw: st.DrawFn, packets: oi.PacketList, *, header_in_sum: bool = True) -> bytes:
    """Draw frames of a list, with many bytes that look like headers and packet numbers."""
    confusing = st.sampled_from([oi.HEADER, packets.length, *packets.ids, 0, 255])
    size = packets.reply_size
    reply = bytes(draw(st.lists(confusing, min_size=size, max_size=size)))
    values = packets._values.unpack(reply)
    return packets.pack_frame(values, header_in_sum=header_in_sum)
