# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Power, buttons, serial port and answers of the simulated Create, one test for each sentence.

Sections Physical Connections, Serial Port Settings, Baud, Input Commands, Sensor Packets and
their quick reference.
"""

from collections.abc import Callable
from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.oi import Checksum, Mode
from create_oi_ros.sim.firmware.guesses import Guesses, parse_guesses
from create_oi_ros.sim.world import shipped
from support.robot import GENTLE, Robot
import vectors

ASK_MODE = bytes([142, 35])


@pytest.fixture
def robot() -> Robot:
    """Return a robot that has been started."""
    return Robot(Mode.PASSIVE)


def booted(robot: Robot) -> Robot:
    """Switch a robot off and on, and wait until it hears."""
    robot.create.power(False, robot.now)
    robot.create.power(True, robot.now)
    robot.run(3.1)
    return robot


# Serial Port Settings.

@pytest.mark.parametrize('ends', [
    booted, lambda robot: robot.create.lose_battery(robot.now)], ids=['power', 'battery'])
def test_a_rate_lasts_until_the_power_is_turned_off_or_the_battery_removed(
        robot: Robot, ends: Callable[[Robot], object]) -> None:
    robot.say(oi.Baud(code=7))
    assert robot.create.baud == 19200
    ends(robot)
    assert robot.create.baud == 57600


def test_the_battery_voltage_below_the_minimum_turns_the_robot_off() -> None:
    robot = Robot(Mode.FULL)
    robot.body.set_battery(charge=0)
    robot.slots()
    assert not robot.create.powered
    robot.create.power(True, robot.now)
    assert not robot.create.powered
    robot.body.set_battery(charge=0.5)
    robot.create.power(True, robot.now)
    robot.run(4)
    robot.say(oi.Start())
    assert robot.mode is Mode.PASSIVE


# Baud.

@pytest.mark.parametrize(('code', 'rate'), vectors.BAUD_CODES.items())
def test_baud_sets_the_rate_according_to_its_code(robot: Robot, code: int, rate: int) -> None:
    robot.say(bytes([129, code]))
    robot.run(0.2)
    assert robot.create.baud == rate
    assert robot.say(ASK_MODE, baud=rate) == b'\x01'


def test_you_must_wait_100_ms_after_sending_baud(robot: Robot) -> None:
    assert robot.say(bytes([129, 7]) + ASK_MODE) == b''
    robot.run(0.08)
    assert robot.say(ASK_MODE, baud=19200) == b''
    robot.run(0.04)
    assert robot.say(ASK_MODE, baud=19200) == b'\x01'


@pytest.mark.parametrize('rate', [19200, 38400, 115200])
def test_a_host_that_listens_at_the_wrong_rate_receives_garbage(robot: Robot, rate: int) -> None:
    robot.say(bytes([148, 1, 35]))
    robot.create.host_baud(rate)
    said = robot.run(1.5)
    assert said
    assert bytes([19, 2, 35, 1]) not in said


def test_at_115200_bytes_too_close_together_may_be_lost() -> None:
    for overrun, answer in ((False, b'\x01'), (True, b'')):
        robot = Robot(Mode.PASSIVE, guesses=Guesses(overrun=overrun))
        robot.say(bytes([129, 11]))
        robot.run(0.2)
        assert robot.say(ASK_MODE) == answer


# Physical Connections: power.

def test_a_robot_that_is_off_neither_hears_nor_speaks_nor_moves() -> None:
    robot = Robot(Mode.FULL)
    robot.say(bytes([148, 1, 7]), GENTLE)
    robot.run(1)
    robot.create.power(False, robot.now)
    robot.create.data_to_send()
    assert robot.say(oi.Start(), ASK_MODE) == b''
    assert robot.run(2) == b''
    assert robot.speed == 0
    assert robot.create.lights == (0, 0, 0)


def test_at_power_on_it_says_some_140_bytes_of_ascii() -> None:
    robot = Robot()
    robot.create.power(False, robot.now)
    robot.create.power(True, robot.now)
    banner = robot.run(1)
    assert 130 < len(banner) < 150
    assert banner.isascii()
    assert b'RDK by iRobot!' in banner


def test_opcode_7_restarts_the_robot() -> None:
    robot = Robot(Mode.FULL)
    assert b'RDK by iRobot!' in robot.say(bytes([7]))
    assert robot.mode is Mode.OFF
    robot.run(4)
    assert robot.say(oi.Start(), ASK_MODE) == b'\x01'


def test_banner_boot_time_and_opcode_7_are_guesses_with_switches() -> None:
    plain = Guesses(banner=False, boot_seconds=0.0, opcode_7_resets=False)
    robot = Robot(Mode.FULL, guesses=plain)
    assert robot.say(bytes([7]) + ASK_MODE) == b'\x03'
    robot.create.power(False, robot.now)
    robot.create.power(True, robot.now)
    assert robot.say(oi.Start(), ASK_MODE) == b'\x01'


def test_songs_scripts_and_requests_are_forgotten_at_power_off() -> None:
    robot = Robot(Mode.FULL)
    robot.say(oi.Song(number=0, notes=(oi.Note(60, 64),)), oi.Script(script=b'\x99'), GENTLE)
    booted(robot)
    robot.create.data_to_send()
    assert robot.say(oi.Start(), oi.Full(), bytes([154])) == b'\0'
    robot.say(oi.PlaySong(number=0))
    assert not robot.read('song_playing')
    assert robot.ask(41, 42) == bytes(4)


# Buttons.

@pytest.mark.parametrize('mode', [Mode.OFF, Mode.PASSIVE])
def test_advance_chooses_a_demo_and_play_plays_and_stops_it(mode: Mode) -> None:
    robot = Robot(mode)
    for button in ('advance', 'advance', 'play'):
        robot.body.force(seconds=0.1, **{button: 1})
        robot.run(0.5)
    assert robot.create.demo is oi.DemoNumber.SPOT_COVER
    robot.body.force(seconds=0.1, play=1)
    robot.run(2)
    assert (robot.create.demo, robot.speed, robot.mode) == (None, 0, mode)


def test_guesses_are_read_from_text_and_refused_with_the_reason() -> None:
    _, guesses = parse_guesses(['boot_seconds=0.5', 'banner=false', 'transmit_buffer=64'])
    assert guesses == Guesses(boot_seconds=0.5, banner=False, transmit_buffer=64)
    for text in ('boot=1', 'banner=2', 'boot_seconds=-1', 'boot_seconds=x', 'transmit_buffer=1.5',
                 'boot_seconds=nan', 'boot_seconds=inf', ''):
        with pytest.raises(ValueError, match='allowed|not a number'):
            parse_guesses([text])


# Any bytes.


AT_ONCE = Guesses(opcode_7_resets=False, boot_seconds=0.0)
OPCODES = st.sampled_from([kind.opcode for kind in oi.COMMANDS])
BYTES = st.lists(st.integers(0, 255) | OPCODES, max_size=60).map(bytes)


@given(st.lists(st.tuples(BYTES, st.floats(0, 0.5), st.sampled_from([None, 300, 57600, 115200])),
                max_size=8),
       st.sampled_from(list(Mode)), st.booleans())
@settings(max_examples=100)
def test_no_bytes_raise(
        sent: list[tuple[bytes, float, int | None]], mode: Mode, resets: bool) -> None:
    robot = Robot(mode, world=shipped('table'), guesses=Guesses(
        opcode_7_resets=resets, boot_seconds=0.1, overrun=resets))
    for data, seconds, baud in sent:
        robot.say(data, baud=baud)
        robot.run(seconds)
    assert robot.mode in Mode


def test_a_robot_recovers_from_any_bytes_by_harmless_ones() -> None:
    """As a driver does on connecting: at most 2 + 2 * 255 bytes end any incomplete command."""
    random = Random(7)
    for _ in range(200):
        robot = Robot(Mode.PASSIVE, guesses=AT_ONCE)
        robot.say(bytes([140, 0, 255]) + random.randbytes(random.randrange(20)))
        robot.say(bytes(600), oi.Start(), oi.Safe())
        assert robot.mode is Mode.SAFE


# What is answered.


# Sensors.

def test_there_are_43_different_sensor_packets_and_others_are_not_answered(robot: Robot) -> None:
    for packet in range(43):
        assert len(robot.say(bytes([142, packet]))) == oi.size_of(packet)
        assert robot.slots(2) == b''
    for packet in (43, 100, 255):
        assert robot.say(bytes([142, packet])) == b'', packet
        assert robot.slots(10) == b'', packet
        assert robot.say(bytes([142, 35])) == b'\x01', packet


@pytest.mark.parametrize(('group', 'sizes'), vectors.GROUPS.items())
def test_group_packets_send_their_component_values_in_sequential_order(
        group: int, sizes: tuple[int, int, int]) -> None:
    robot, other = Robot(Mode.SAFE), Robot(Mode.SAFE)
    for each in (robot, other):
        each.body.force(bump_left=1, wall_signal=1234, infrared=130, analog=1023, advance=1)
        each.say(oi.DriveDirect(right=100, left=-300))
        each.run(0.5)
    assert robot.say(bytes([142, group])) == b''.join(
        other.say(bytes([142, packet])) for packet in range(sizes[1], sizes[2] + 1))


def test_create_updates_these_values_every_15_ms(robot: Robot) -> None:
    robot.body.push(speed=0.2, rate=0, seconds=1)
    robot.run(0.3)
    robot.ask(19)
    readings = []
    for _ in range(4):
        robot.run(0.005)
        readings.append(robot.ask(19)[1])
    assert readings == [0, 0, 3, 0]


# Query List.

def test_the_robot_returns_up_to_255_packets_in_the_order_you_specify(robot: Robot) -> None:
    robot.body.force(bump_right=1, cliff_left_signal=0x0225)
    assert robot.say(bytes([149, 4, 28, 35, 7, 35])) == b'\x02\x25\x01\x01\x01'
    assert robot.say(bytes([149, 255] + [35] * 255)) == b'\x01' * 255
    assert len(robot.say(bytes([149, 255] + [6] * 255))) == 255 * 52
    assert robot.say(bytes([149, 0])) == b''


# Stream.


@pytest.mark.parametrize(('checksum', 'start'), [(Checksum.MANUAL, 1), (Checksum.HARDWARE, 0)])
def test_the_checksum_makes_the_low_byte_of_the_sum_0(checksum: Checksum, start: int) -> None:
    robot = Robot(Mode.PASSIVE, checksum=checksum)
    robot.say(bytes([148, 36, *range(7, 43)]))
    frame = robot.slots()
    assert sum(frame[start:]) % 256 == 0
    assert len(frame) == 3 + 36 + 52
    assert frame[1] == len(frame) - 3


def test_the_list_is_sent_every_15_ms_until_it_is_empty(robot: Robot) -> None:
    robot.say(bytes([148, 1, 7]))
    assert len(robot.run(15)) == 1000 * 5
    assert [len(robot.run(0.005)) for _ in range(6)] == [0, 0, 5, 0, 0, 5]
    robot.say(bytes([148, 0]))
    assert robot.slots(10) == b''
    assert robot.read('stream_packets') == 0


def test_the_same_packet_may_be_asked_for_twice() -> None:
    robot = Robot(Mode.FULL)
    robot.say(GENTLE)
    robot.run(1)
    robot.say(bytes([148, 2, 19, 19]))
    frame = robot.slots()
    assert frame[3:5] != b'\0\0'
    assert frame[6:8] == b'\0\0'


@pytest.mark.parametrize('mode', [oi.Start(), oi.Safe(), oi.Full()])
def test_the_list_survives_a_mode_change_and_start(robot: Robot, mode: oi.Command) -> None:
    robot.say(bytes([148, 2, 7, 8]), mode)
    assert len(robot.slots(2)) == 2 * 7
    assert robot.read('stream_packets') == 2


@pytest.mark.parametrize(('baud', 'capacity'), [(57600, 86), (19200, 28)])
def test_a_maximum_of_86_bytes_can_be_sent_in_15_ms(
        robot: Robot, baud: int, capacity: int) -> None:
    robot.say(oi.Baud(code=oi.BaudCode[f'B{baud}']))
    robot.run(0.2)
    fits = [7] * ((capacity - 3) // 2)
    robot.say(bytes([148, len(fits), *fits]))
    assert intact(robot.run(15), fits) == 1000


@pytest.mark.parametrize(('baud', 'packets'), [
    (57600, [*range(7, 43)]), (19200, [7] * 14), (57600, [6] * 43)])
def test_if_more_data_is_requested_the_stream_will_eventually_become_corrupted(
        robot: Robot, baud: int, packets: list[int]) -> None:
    robot.say(oi.Baud(code=oi.BaudCode[f'B{baud}']))
    robot.run(0.2)
    robot.say(bytes([148, len(packets), *packets]))
    sent = robot.run(15)
    assert intact(sent, packets) < 950
    assert len(sent) <= 15 * baud / 10 + 300


def intact(sent: bytes, packets: list[int]) -> int:
    """Count frames whose header, length, packets and checksum are right."""
    reader = oi.StreamReader([oi.PacketList(packets)])
    reader.feed(sent)
    return sum(isinstance(event, oi.Frame) for event in reader.finish())


# Pause/Resume Stream.

def test_pause_keeps_the_list_and_resume_uses_it(robot: Robot) -> None:
    robot.say(bytes([148, 2, 7, 8]), bytes([150, 0]))
    assert robot.slots(10) == b''
    assert robot.read('stream_packets') == 2
    robot.say(bytes([150, 1]))
    assert len(robot.slots(3)) == 3 * 7


# Sensor Packets: each bit and value, by its byte on the wire.

BITS = [
    ('bump_right', 7, 1), ('bump_left', 7, 2), ('drop_right', 7, 4), ('drop_left', 7, 8),
    ('drop_caster', 7, 16), ('wall', 8, 1), ('cliff_left', 9, 1), ('cliff_front_left', 10, 1),
    ('cliff_front_right', 11, 1), ('cliff_right', 12, 1), ('virtual_wall', 13, 1),
    ('overcurrent_ld1', 14, 1), ('overcurrent_ld0', 14, 2), ('overcurrent_ld2', 14, 4),
    ('overcurrent_right_wheel', 14, 8), ('overcurrent_left_wheel', 14, 16),
    ('play', 18, 1), ('advance', 18, 4), ('digital_input_0', 32, 16 + 1),
    ('digital_input_1', 32, 16 + 2), ('digital_input_2', 32, 16 + 4),
    ('digital_input_3', 32, 16 + 8), ('internal_charger', 34, 1), ('home_base', 34, 2)]


@pytest.mark.parametrize(('sensor', 'packet', 'value', 'sent'), [
    *((sensor, packet, 1, bytes([byte])) for sensor, packet, byte in BITS),
    ('infrared', 17, 254, b'\xfe'), ('charging_state', 21, 5, b'\x05'),
    ('voltage', 22, 16000, b'\x3e\x80'), ('current', 23, -300, b'\xfe\xd4'),
    ('temperature', 24, -5, b'\xfb'), ('charge', 25, 2600, b'\x0a\x28'),
    ('capacity', 26, 2696, b'\x0a\x88'), ('wall_signal', 27, 4095, b'\x0f\xff'),
    ('cliff_left_signal', 28, 258, b'\x01\x02'),
    ('cliff_front_left_signal', 29, 772, b'\x03\x04'),
    ('cliff_front_right_signal', 30, 1286, b'\x05\x06'),
    ('cliff_right_signal', 31, 1800, b'\x07\x08'), ('analog', 33, 1023, b'\x03\xff')])
def test_bits_and_values_are_sent_as_the_manual_says(
        sensor: str, packet: int, value: int, sent: bytes) -> None:
    robot = Robot(Mode.FULL)
    robot.body.force(**{sensor: value})
    assert robot.ask(packet) == sent


def test_what_nobody_touches_has_its_documented_value(robot: Robot) -> None:
    """No infrared is 255, the baud rate change pin is high, unused bytes are 0."""
    assert robot.ask(17, 32, 15, 16) == b'\xff\x10\0\0'


# Distance and Angle.

@pytest.mark.parametrize(('right', 'left', 'distance', 'angle'), [
    (200, 200, 1000, 0), (-200, -200, -1000, 0), (100, -100, 0, 222), (-100, 100, 0, -222)])
def test_distance_is_forward_positive_and_angle_counter_clockwise_positive(
        right: int, left: int, distance: int, angle: int) -> None:
    robot = Robot(Mode.FULL)
    robot.say(oi.DriveDirect(right=right, left=left))
    robot.run(1)
    robot.ask(19, 20)
    robot.run(5.01)
    sent = robot.ask(19, 20)
    assert int.from_bytes(sent[:2], signed=True) == pytest.approx(distance, rel=0.005)
    assert int.from_bytes(sent[2:], signed=True) == pytest.approx(angle, rel=0.005)


@settings(max_examples=30)
@given(st.lists(st.floats(0.001, 0.2), max_size=20))
def test_it_does_not_matter_how_often_one_polls(cuts: list[float]) -> None:
    robots = [Robot(Mode.SAFE) for _ in range(2)]
    for robot in robots:
        robot.say(bytes([148, 3, 7, 19, 20]), oi.Song(number=0, notes=(oi.Note(60, 9),)),
                  oi.PlaySong(number=0), oi.DriveDirect(right=321, left=-123))
    whole, cut = robots
    parts = b''.join(cut.run(each) for each in cuts)
    whole.now = cut.now
    whole.create.poll(whole.now)
    assert whole.create.data_to_send() == parts
    assert whole.body.truth() == cut.body.truth()
