# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the simulated Create does by its actuators, one test for each sentence of the manual.

Section Actuator Commands, and the packets that report on them (36, 37, 39 to 42).
"""

import math

import pytest

from create_oi_ros import oi
from create_oi_ros.oi import Mode, Note
from create_oi_ros.sim.firmware.guesses import Guesses
from support.robot import Robot

SEPARATION = 258
ONE_NOTE, OTHER_NOTE = (Note(60, 32),), (Note(72, 64), Note(0, 64), Note(74, 64))


@pytest.fixture
def robot() -> Robot:
    """Return a robot in Full mode on endless floor."""
    return Robot(Mode.FULL)


# Drive.

def test_drive_example_reverses_at_200_turning_at_a_radius_of_500(robot: Robot) -> None:
    robot.say(bytes([137, 255, 56, 1, 244]))
    assert robot.read('requested_velocity') == -200
    assert robot.read('requested_radius') == 500
    robot.run(1)
    truth = robot.body.truth()
    assert truth.speed == pytest.approx(-0.2)
    assert truth.rate == pytest.approx(-0.2 / 0.5)


def test_the_radius_is_measured_from_the_center_of_the_turning_circle_to_the_center_of_create(
        robot: Robot) -> None:
    robot.say(oi.Drive(velocity=200, radius=500))
    robot.run(2)
    here = robot.body.truth().pose
    center = (here.x - 0.5 * math.sin(here.yaw), here.y + 0.5 * math.cos(here.yaw))
    robot.run(3)
    there = robot.body.truth().pose
    assert math.dist(center, (there.x, there.y)) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize('code', [b'\x80\x00', b'\x7f\xff'])
def test_straight_is_hex_8000_or_7fff(robot: Robot, code: bytes) -> None:
    robot.say(bytes([137, 0, 200]) + code)
    robot.run(1)
    assert robot.body.truth().rate == 0
    assert robot.speed == pytest.approx(0.2)
    assert robot.ask(40) == code


@pytest.mark.parametrize(('code', 'right'), [(b'\xff\xff', -100), (b'\x00\x01', 100)])
def test_turn_in_place_is_hex_ffff_clockwise_and_0001_counter_clockwise(
        robot: Robot, code: bytes, right: int) -> None:
    robot.say(b'\x89\x00\x64' + code)
    robot.run(1)
    assert robot.wheels == (right, -right)
    assert (robot.speed, robot.body.truth().rate) == pytest.approx((0, right / 1000 / 0.129))


def test_a_radius_of_0_is_taken_as_straight(robot: Robot) -> None:
    robot.say(oi.Drive(velocity=100, radius=0))
    assert robot.wheels == (100, 100)


def test_a_radius_out_of_range_is_the_longest(robot: Robot) -> None:
    robot.say(bytes([137, 0, 200, *(9000).to_bytes(2)]))
    assert robot.read('requested_radius') == 2000
    assert robot.wheels[0] > robot.wheels[1]
    robot.say(bytes([137, 0, 200, *(-9000).to_bytes(2, signed=True)]))
    assert robot.wheels[0] < robot.wheels[1]


@pytest.mark.parametrize(('asked', 'got'), [(32767, 500), (501, 500), (-501, -500)])
def test_a_velocity_out_of_range_is_clamped(robot: Robot, asked: int, got: int) -> None:
    word = asked.to_bytes(2, signed=True)
    robot.say(b'\x89' + word + b'\x7f\xff', b'\x91' + word + word)
    assert robot.read('requested_velocity') == got
    assert robot.read('requested_right_velocity') == got
    assert robot.read('requested_left_velocity') == got


# Drive Direct.

def test_drive_direct_controls_the_wheels_independently_right_first(robot: Robot) -> None:
    robot.say(bytes([145, 0, 200, 255, 156]))
    assert robot.wheels == (200, -100)
    robot.run(1)
    truth = robot.body.truth()
    assert (truth.speed, truth.rate) == pytest.approx((0.05, 0.3 / 0.258))


def test_drive_and_drive_direct_report_in_their_own_packets(robot: Robot) -> None:
    robot.say(oi.Drive(velocity=120, radius=-340), oi.DriveDirect(right=56, left=-78))
    assert robot.ask(39, 40, 41, 42) == bytes([0, 120, 254, 172, 0, 56, 255, 178])


# LEDs.

def test_leds_example_lights_advance_and_power_green_at_half_intensity(robot: Robot) -> None:
    robot.say(bytes([139, 8, 0, 128]))
    assert robot.create.lights == (oi.LedBits.ADVANCE, 0, 128)


@pytest.mark.parametrize('masks', [True, False])
def test_whether_bits_without_a_meaning_count_is_a_guess_with_a_switch(masks: bool) -> None:
    """139 25 0 128 was seen to light Advance."""
    robot = Robot(Mode.FULL, guesses=Guesses(mask_bits=masks))
    robot.say(bytes([139, 25, 0, 128]), bytes([138, 0xf9]), bytes([147, 0xfc]))
    state = robot.create.actuators
    before = (oi.LedBits(0), 0, 0), (0, 0, 0), 0
    after = (oi.LedBits.ADVANCE, 0, 128), (128, 0, 0), 4
    assert (state.lights, state.duties, state.outputs) == (after if masks else before)


def test_other_values_out_of_range_are_not_masked(robot: Robot) -> None:
    robot.say(bytes([144, 129, 0, 0]), bytes([141, 16]))
    assert robot.create.actuators.duties == (0, 0, 0)
    assert not robot.read('song_playing')


def test_in_passive_the_robot_lights_its_own_leds() -> None:
    robot = Robot(Mode.PASSIVE)
    robot.body.set_battery(charge=0.0)
    empty = robot.create.lights
    robot.body.set_battery(charge=1.0)
    assert (empty.color, robot.create.lights.color) == (255, 0)


# Digital Outputs.

def test_digital_outputs_are_set_by_three_bits(robot: Robot) -> None:
    for bits in range(8):
        robot.say(bytes([147, bits]))
        assert robot.create.outputs == bits


def test_when_switched_on_the_digital_outputs_are_high_for_the_first_3_seconds() -> None:
    robot = Robot()
    robot.create.power(False, robot.now)
    assert robot.create.outputs == 0
    robot.create.power(True, robot.now)
    assert robot.create.outputs == 7
    robot.run(2.9)
    assert robot.create.outputs == 7
    robot.run(0.2)
    assert robot.create.outputs == 0


# Low side drivers.

def test_pwm_example_turns_on_driver_2_at_25_and_driver_0_at_100_per_cent(robot: Robot) -> None:
    robot.say(bytes([144, 32, 0, 128]))
    assert robot.create.actuators.duties == (128, 0, 32)


def test_low_side_drivers_example_turns_on_only_driver_1(robot: Robot) -> None:
    robot.say(bytes([138, 7]), bytes([138, 2]))
    assert robot.create.actuators.duties == (0, 128, 0)


@pytest.mark.parametrize(('amperes', 'flags'), [
    ({'ld0': 0.6}, 0b010), ({'ld1': 0.6}, 0b001), ({'ld2': 1.8}, 0b100),
    ({'ld0': 0.4, 'ld1': 0.4, 'ld2': 1.4}, 0)])
def test_if_too_much_current_is_requested_the_overcurrent_flag_is_set(
        robot: Robot, amperes: dict[str, float], flags: int) -> None:
    robot.body.load(**amperes)
    robot.say(bytes([138, 7]))
    robot.run(1)
    assert robot.ask(14) == bytes([flags])


def test_passive_stops_the_drivers() -> None:
    robot = Robot(Mode.SAFE)
    robot.say(oi.LowSideDrivers(bits=7), oi.Start())
    assert robot.create.actuators.duties == (0, 0, 0)


# Send IR.

def test_send_ir_sends_the_requested_byte(robot: Robot) -> None:
    robot.say(bytes([151, 200, 151, 0]))
    assert list(robot.create.actuators.infrared_sent) == [200, 0]


# Song and Play Song.

def test_you_can_specify_up_to_sixteen_songs_of_up_to_sixteen_notes(robot: Robot) -> None:
    for number in range(16):
        robot.say(oi.Song(number=number, notes=(Note(40 + number, 1),) * 16))
    for number in range(16):
        robot.say(oi.PlaySong(number=number))
        assert robot.create.note == 40 + number
        assert robot.read('song_number') == number
        robot.run(16 / 64 + 0.015)


@pytest.mark.parametrize('song', [bytes([140, 16, 1, 60, 60]), bytes([140, 0, 17] + [60] * 34),
                                  bytes([140, 0, 0])])
def test_a_song_out_of_range_is_ignored_but_its_bytes_are_taken(
        robot: Robot, song: bytes) -> None:
    robot.say(song, oi.PlaySong(number=0), bytes([141, 16]))
    assert not robot.read('song_playing')


def test_a_second_song_with_the_same_number_overwrites_the_old_one(robot: Robot) -> None:
    robot.say(oi.Song(number=3, notes=ONE_NOTE), oi.Song(number=3, notes=OTHER_NOTE),
              oi.PlaySong(number=3))
    assert robot.create.note == 72


@pytest.mark.parametrize('mode', [Mode.PASSIVE, Mode.SAFE, Mode.FULL])
def test_songs_can_be_stored_in_passive_safe_and_full(mode: Mode) -> None:
    robot = Robot(mode)
    robot.say(oi.Song(number=0, notes=ONE_NOTE), oi.Full(), oi.PlaySong(number=0))
    assert robot.read('song_playing')


@pytest.mark.parametrize(('number', 'sounds'), [
    (30, False), (31, True), (127, True), (128, False), (0, False), (255, False)])
def test_notes_outside_the_range_of_31_to_127_are_rests(
        robot: Robot, number: int, sounds: bool) -> None:
    robot.say(oi.Song(number=0, notes=(Note(number, 64),)), oi.PlaySong(number=0))
    assert robot.create.note == (number if sounds else oi.REST)
    assert robot.read('song_playing')


def test_a_half_second_long_note_has_a_duration_of_32(robot: Robot) -> None:
    robot.say(oi.Song(number=0, notes=ONE_NOTE), oi.PlaySong(number=0))
    robot.run(0.48)
    assert robot.read('song_playing')
    robot.run(0.03)
    assert not robot.read('song_playing')


def test_play_does_not_work_if_a_song_is_already_playing(robot: Robot) -> None:
    robot.say(oi.Song(number=0, notes=OTHER_NOTE), oi.Song(number=1, notes=ONE_NOTE),
              oi.PlaySong(number=0), oi.PlaySong(number=1))
    assert robot.read('song_number') == 0
    robot.run(1.5)
    assert robot.create.note == 0
    robot.run(1.4)
    assert robot.create.note == 74
    robot.run(0.2)
    robot.say(oi.PlaySong(number=1))
    assert (robot.read('song_number'), robot.create.note) == (1, 60)
