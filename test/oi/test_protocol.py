# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands and packets against the manual: bytes, ranges, modes; each has a test vector."""

from math import isnan
import re
from typing import Annotated, Any

import pytest

from create_oi_ros import oi
from create_oi_ros.oi.commands import wheel_speeds
from create_oi_ros.oi.tools.text import parse_commands
from create_oi_ros.oi.wire import Counted, Wire
import vectors


@pytest.mark.parametrize(('command', 'sent'), vectors.COMMANDS, ids=str)
def test_the_bytes_of_commands_are_the_manuals(command: oi.Command, sent: bytes) -> None:
    assert command.encode() == sent
    decoded = type(command).decode(sent)
    assert decoded == command and type(decoded) is type(command)


def untested_commands() -> list[str]:
    """Name what no vector tests: commands, signs, byte order, order of fields."""
    lacking = []
    for kind in oi.COMMANDS:
        shown = [command for command, _ in vectors.COMMANDS if type(command) is kind]
        if not shown:
            lacking.append(kind.title)
        for name, wire in kind.fields:
            values = [int(getattr(command, name)) for command in shown]
            if wire.format in 'bh' and min(values, default=0) >= 0:
                lacking.append(f'{kind.title}.{name}: sign')
            if wire.format == 'B' and wire.high > 127 and max(values, default=0) < 128:
                lacking.append(f'{kind.title}.{name}: no sign')
            if wire.format in 'hH' and all(v & 0xff == v >> 8 & 0xff for v in values):
                lacking.append(f'{kind.title}.{name}: byte order')
        numbers = [[getattr(command, name) for name, _ in kind.fields] for command in shown]
        if shown and not any(len(set(row)) == len(row) for row in numbers):
            lacking.append(f'{kind.title}: order of fields')
        if kind.tail and max((len(getattr(c, kind.tail.name)) for c in shown), default=0) < 2:
            lacking.append(f'{kind.title}: order of {kind.tail.name}')
    return lacking


def test_every_command_has_a_vector_that_shows_sign_and_order() -> None:
    assert untested_commands() == []


def test_all_commands_of_the_manual_are_there_with_its_names_and_modes() -> None:
    assert {kind.opcode: (
        kind.title, ' '.join(mode.name.lower() for mode in oi.Mode if mode in kind.modes),
        kind.enters.name.lower() if kind.enters is not None else '') for kind in oi.COMMANDS
        } == vectors.COMMAND_FACTS


@pytest.mark.parametrize('name', vectors.NAMED_NUMBERS)
def test_named_numbers_are_the_manuals(name: str) -> None:
    members = getattr(oi, name)
    assert {member.value: member.name for member in members} == vectors.NAMED_NUMBERS[name]


def test_baud_codes_are_the_manuals() -> None:
    assert {code.value: code.rate for code in oi.BaudCode} == vectors.BAUD_CODES


@pytest.mark.parametrize(
    'command, name', vectors.OUT_OF_RANGE, ids=lambda value: str(value) if value else None)
def test_a_value_out_of_range_is_refused_on_encoding(command: oi.Command, name: str) -> None:
    with pytest.raises(ValueError) as refused:
        command.encode()
    message = str(refused.value)
    assert message.startswith(f'{command.title}: {name} ') and 'allowed: ' in message


def test_straight_may_be_written_as_the_manual_does() -> None:
    straight = oi.Drive(velocity=200, radius=0x8000)
    assert straight == oi.Drive(velocity=200, radius=-0x8000)
    assert straight.radius is oi.Radius.STRAIGHT
    assert oi.Drive.decode(straight.encode()) == straight
    assert parse_commands('drive velocity=200 radius=0x8000') == [straight]
    assert parse_commands('drive velocity=200 radius=32768') == [straight]


@pytest.mark.parametrize('command, message', [
    (oi.Drive(velocity=0, radius=2001),
     'Drive: radius = 2001; allowed: -2000 to 2000 mm, -32768 STRAIGHT, 32767 STRAIGHT_7FFF'),
    (oi.Drive(velocity=0, radius='left'),  # type: ignore[arg-type]
     "Drive: radius = 'left'; allowed: -2000 to 2000 mm, -32768 STRAIGHT, 32767 STRAIGHT_7FFF"),
    (oi.Song(number=0, notes=((60, 32), (60,))),  # type: ignore[arg-type]
     'Song: notes[1] = (60,) needs 2 numbers'),
    (oi.Drive(velocity=0.5, radius=0),  # type: ignore[arg-type]
     'Drive: velocity = 0.5; allowed: -500 to 500 mm/s'),
    (oi.Stream(packets=7),  # type: ignore[arg-type]
     'Stream: packets = 7; allowed: 0 to 43 packets'),
], ids=str)
def test_an_error_names_field_value_and_range(command: oi.Command, message: str) -> None:
    with pytest.raises(ValueError) as refused:
        command.encode()
    assert str(refused.value) == message


@pytest.mark.parametrize('kind, encoded', [
    (oi.Drive, b''), (oi.Drive, b'\x89\x00\x00\x00'), (oi.Drive, b'\x89\x00\x00\x00\x00\x00'),
    (oi.Drive, b'\x91\x00\x00\x00\x00'), (oi.Song, b'\x8c\x00\x01\x3c'), (oi.Start, b'\x80\x80'),
])
def test_bytes_of_another_length_or_command_are_refused(
        kind: type[oi.Command], encoded: bytes) -> None:
    with pytest.raises(ValueError, match=f'is not one whole {kind.title} command'):
        kind.decode(encoded)


def test_decoded_numbers_have_their_names() -> None:
    assert oi.Baud.decode(b'\x81\x0a').code is oi.BaudCode.B57600
    assert oi.Drive.decode(bytes([137, 0, 0, 128, 0])).radius is oi.Radius.STRAIGHT
    assert isinstance(oi.Leds.decode(bytes([139, 8, 0, 0])).bits, oi.LedBits)
    assert oi.Song.decode(bytes([140, 0, 1, 60, 32])).notes[0].number == 60


def test_two_commands_of_one_opcode_and_fields_behind_a_counted_one_are_refused() -> None:
    with pytest.raises(TypeError, match='opcode 137 of Twin is already that of Drive'):
        class Twin(oi.Command, title='Twin', opcode=137, section='', modes=frozenset(oi.Mode)):
            pass
    assert oi.Command.by_opcode[137] is oi.Drive
    with pytest.raises(TypeError, match='Odd.after follows a counted field'):
        class Odd(oi.Command, title='Odd', opcode=1, section='', modes=frozenset(oi.Mode)):
            many: Annotated[bytes, Counted(0, 1, (Wire('B', 0, 255),), 'bytes')]
            after: Annotated[int, Wire('B', 0, 255)]
    assert 1 not in oi.Command.by_opcode


@pytest.mark.parametrize('kind, arguments, message', [
    (oi.DriveDirect, (200, 100),
     'DriveDirect takes its fields by name: DriveDirect(right=..., left=...), not (200, 100)'),
    (oi.Stream, ([7],), 'Stream takes its fields by name: Stream(packets=...), not ([7],)'),
    (oi.Safe, (1,), 'Safe takes its fields by name: Safe(), not (1,)')])
def test_values_without_a_name_are_refused(
        kind: type[oi.Command], arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(TypeError) as refused:
        kind(*arguments)
    assert str(refused.value) == message


def test_packets_may_be_given_by_their_names_and_no_others() -> None:
    assert oi.Sensors(packet='angle') == oi.Sensors(packet=20)
    assert oi.Stream(packets=['angle', 7]) == oi.Stream(packets=(20, 7))
    assert oi.QueryList(packets=['angle']).encode() == bytes([149, 1, 20])
    assert oi.size_of('voltage') == oi.size_of(22)
    for make in (lambda: oi.Sensors(packet='bump'), lambda: oi.Stream(packets=('bump',)),
                 lambda: oi.PacketList(['bump']), lambda: oi.size_of('bump')):
        with pytest.raises(ValueError, match="no packet is named 'bump'; allowed: bumps_and"):
            make()
    with pytest.raises(ValueError, match=r"packets = 'wall'; allowed: a list, such as \['wall'\]"):
        oi.QueryList(packets='wall')


# Wheel speeds of Drive.

@pytest.mark.parametrize('velocity, radius, separation, right, left', [
    (-200, -32768, 258.0, -200, -200), (-200, 32767, 258.0, -200, -200),
    (-200, 0, 258.0, -200, -200), (200, -1, 258.0, -200, 200), (200, 1, 258.0, 200, -200),
    (200, 258, 258.0, 300, 100), (200, -258, 258.0, 100, 300), (-200, 258, 258.0, -300, -100),
    (1, 2, 257.0, 65.25, -63.25)])
def test_a_positive_radius_turns_left_straight_does_not_and_nothing_is_rounded(
        velocity: int, radius: int, separation: float, right: float, left: float) -> None:
    assert wheel_speeds(velocity, radius, separation) == (right, left)


# Sensor packets: bytes, sizes, ranges, groups, the stream budget.


EVERYTHING = oi.PacketList(oi.PACKETS)


@pytest.mark.parametrize(('number', 'sent', 'value'), vectors.PACKETS, ids=str)
def test_the_bytes_of_packets_are_the_manuals(number: int, sent: bytes, value: int) -> None:
    packets = oi.PacketList([number])
    found = getattr(packets.unpack_reply(sent), oi.NAMES[number])
    assert found == value and type(found) is type(value)
    assert packets.pack_reply([int(value)]) == sent


def untested_packets() -> list[str]:
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
    assert untested_packets() == []


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
