# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Sensor packets against the manual: bytes, sizes, ranges, groups, the stream budget."""

from math import isnan
import re

import pytest

from create_oi_ros import oi
import vectors

EVERYTHING = oi.PacketList(oi.PACKETS)


@pytest.mark.parametrize(('number', 'sent', 'value'), vectors.PACKETS, ids=str)
def test_the_bytes_are_the_manuals(number: int, sent: bytes, value: int) -> None:
    packets = oi.PacketList([number])
    found = getattr(packets.unpack_reply(sent), oi.NAMES[number])
    assert found == value and type(found) is type(value)
    assert packets.pack_reply([int(value)]) == sent


def untested() -> list[str]:
    """Name what no vector tests: packets, signs, byte order, bits."""
    lacking = []
    for number, (_, title, wire) in oi.PACKETS.items():
        shown = [sent for tested, sent, _ in vectors.PACKETS if tested == number]
        values = [int(value) for tested, _, value in vectors.PACKETS if tested == number]
        top = 0x80 if wire.format in 'bB' else 0x8000
        if not shown:
            lacking.append(title)
        if wire.format in 'bh' and min(values, default=0) >= 0:
            lacking.append(f'{title}: sign')
        elif wire.format == 'H' and max(values, default=0) < top:
            lacking.append(f'{title}: no sign')
        elif wire.format == 'B' and not wire.names and not wire.boolean and (
                max(values, default=0) < top):
            lacking.append(f'{title}: no sign')
        if wire.format in 'hH' and all(len(set(sent)) == 1 for sent in shown):
            lacking.append(f'{title}: byte order')
        if wire.mask and not {int(bit) for bit in wire.names or ()} <= set(values):
            lacking.append(f'{title}: bits')
    return lacking


def test_every_packet_has_a_vector_that_shows_sign_and_order() -> None:
    assert untested() == []


def test_ranges_are_the_manuals() -> None:
    declared = {number: (wire.low, wire.high) for number, (_, _, wire) in oi.PACKETS.items()}
    assert declared | {18: (0, 5)} == vectors.RANGES
    assert declared[18] == (0, oi.Buttons.PLAY + oi.Buttons.ADVANCE)


def test_groups_are_the_manuals() -> None:
    for number, (size, first, last) in vectors.GROUPS.items():
        assert tuple(oi.GROUPS[number]) == tuple(range(first, last + 1))
        assert oi.size_of(number) == size == oi.PacketList([number]).reply_size
    assert set(vectors.GROUPS) == set(oi.GROUPS)


def test_a_reply_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match=r'1 bytes for packets \(9, 13\); expected 2'):
        oi.PacketList([9, 13]).unpack_reply(b'\0')


def test_the_manuals_stream_frame() -> None:
    packets = oi.PacketList([29, 13])
    readings = packets.unpack_frame(vectors.STREAM_FRAME)
    assert readings == oi.Readings(vectors.STREAM_VALUES)
    values = list(vectors.STREAM_VALUES.values())
    assert packets.pack_frame(values, header_in_sum=False) == vectors.STREAM_FRAME
    assert packets.pack_frame(values) == vectors.STREAM_FRAME_OF_REAL_ROBOTS
    assert packets.length == 5 and packets.frame_size == 8


def test_the_stream_budget() -> None:
    for baud, capacity in vectors.STREAM_CAPACITY.items():
        assert EVERYTHING.budget(baud).capacity == capacity
    budget = oi.PacketList([29, 13]).budget(57600)
    assert (budget.size, budget.capacity, budget.seconds) == (8, 86, 80 / 57600)
    assert budget.fits and budget.spare == 78
    full = EVERYTHING.budget(57600)
    assert (full.size, full.spare, full.fits) == (3 + 36 + 52, -5, False)
    assert EVERYTHING.budget(115200).fits
    just = oi.PacketList([*range(7, 15), *range(17, 42)])
    assert just.budget(57600).spare >= 0 and not just.budget(19200).fits


def test_a_list_can_be_given_by_names() -> None:
    packets = oi.PacketList(['distance', 'angle'])
    assert packets == oi.PacketList((19, 20)) and hash(packets) == hash(oi.PacketList([19, 20]))
    assert packets != (19, 20)
    assert repr(packets) == 'PacketList((19, 20))'
    assert packets.names == ('distance', 'angle')


def test_readings_hold_only_what_arrived() -> None:
    readings = oi.PacketList(['distance']).unpack_reply(b'\xff\x38')
    assert readings.has('distance') and not readings.has('distance', 'angle')
    with pytest.raises(AttributeError, match='angle has not arrived'):
        _ = readings.angle
    readings = readings.updated(
        oi.PacketList(['angle', 'oi_mode']).unpack_reply(b'\0\1\2'))
    assert repr(readings) == 'Readings(distance=-200, angle=1, oi_mode=<Mode.SAFE: 2>)'
    assert readings != oi.Readings() and readings != 'readings'


def test_of_a_packet_requested_twice_the_last_value_counts() -> None:
    twice = oi.PacketList([8, 9, 8]).unpack_reply(b'\0\1\1')
    assert twice.wall and twice == oi.Readings({'wall': 1, 'cliff_left': 1})
    assert dict(twice.updated(oi.Readings({'distance': 3})).items()) == {
        'wall': True, 'cliff_left': True, 'distance': 3}
    late = oi.Readings({'cliff_left': 0}).updated(twice)
    assert late == twice


def test_readings_out_of_the_manuals_range_are_kept_and_named() -> None:
    packets = oi.PacketList([
        'wall', 'buttons', 'charging_state', 'wall_signal', 'voltage', 'oi_mode'])
    fine = packets.unpack_reply(bytes([1, 5, 5, 15, 255, 255, 255, 3]))
    assert fine.implausible() == []
    odd = packets.unpack_reply(bytes([2, 2, 6, 16, 0, 255, 255, 4]))
    assert odd.implausible() == ['wall', 'buttons', 'charging_state', 'wall_signal', 'oi_mode']
    assert [odd.wall, odd.charging_state, odd.wall_signal, odd.oi_mode] == [2, 6, 4096, 4]
    assert odd.buttons == 2


def test_bits_that_mean_nothing_are_cleared_and_numbers_out_of_range_are_not_known() -> None:
    packets = oi.PacketList(['wall', 'buttons', 'charging_state', 'oi_mode', 'analog_signal'])
    odd = packets.unpack_reply(bytes([3, 7, 6, 4, 4, 0]))
    fixed = odd.corrected(odd.implausible())
    assert (fixed.wall, fixed.buttons) == (True, oi.Buttons.PLAY | oi.Buttons.ADVANCE)
    assert fixed.charging_state is fixed.oi_mode is fixed.analog_signal is None
    assert isnan(fixed.analog_volts) and fixed.number('oi_mode', 9) == 9


@pytest.mark.parametrize('values, message', [
    ([40000, 0], 'distance (packet 19) = 40000; allowed: -32768 to 32767'),
    ([0, 2.5], 'angle (packet 20) = 2.5; allowed: -32768 to 32767'),
    ([0, None], 'angle (packet 20) = None; allowed: -32768 to 32767'),
    ([0], '1 values for packets (19, 20); expected 2'),
])
def test_values_that_cannot_be_encoded_are_named(values: list[int], message: str) -> None:
    packets = oi.PacketList([19, 20])
    for pack in (packets.pack_reply, packets.pack_frame):
        with pytest.raises(ValueError, match=f'^{re.escape(message)}$'):
            pack(values)


def test_the_analog_input_is_read_in_volts() -> None:
    packets = oi.PacketList(['analog_signal'])
    assert packets.unpack_reply(b'\x03\xff').analog_volts == pytest.approx(5.0)
    assert packets.unpack_reply(b'\0\4').analog_volts == pytest.approx(0.0195, abs=1e-4)
    with pytest.raises(AttributeError, match='analog_signal has not arrived'):
        _ = oi.Readings().analog_volts
