# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The simulated Create's modes and actuators, one test for each sentence of the manual.

Sections are the manual's: iRobot Create Open Interface Modes, Getting Started Commands, Mode
Commands, Open Interface Command Reference, Actuator Commands.
"""

from collections import deque

import pytest

from create_oi_ros import oi
from create_oi_ros.oi import Mode, Note
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import parse, shipped
from support.robot import GENTLE, Robot
import vectors

SAMPLES = {command.opcode: command for command, _ in reversed(vectors.COMMANDS)}
"""A command of each opcode."""


# iRobot Create Open Interface Modes.

def state(robot: Robot) -> tuple[object, ...]:
    """Return all that a command may change."""
    create, actuators = robot.create, robot.create.actuators
    return (create.mode, create.demo, create.lights, create.outputs, create.script, create.baud,
            create.waiting, create.speaker.song_playing(robot.now), dict(create.speaker.songs),
            actuators.duties, actuators.wheels, list(actuators.infrared_sent))


@pytest.mark.parametrize('mode', Mode)
@pytest.mark.parametrize('command', SAMPLES.values(), ids=lambda command: command.title)
def test_a_command_is_obeyed_in_its_modes_only_and_enters_the_manuals(
        command: oi.Command, mode: Mode) -> None:
    _, available, enters = vectors.COMMAND_FACTS[command.opcode]
    robot = Robot(mode)
    robot.say(oi.Song(number=15, notes=(oi.Note(60, 64),)))
    before = state(robot)
    reply = robot.say(command)
    if mode.name.lower() in available.split():
        assert robot.mode is (Mode[enters.upper()] if enters else mode)
    else:
        assert reply + robot.slots(10) == b''
        assert state(robot) == before and robot.speed == 0


# Safe Mode.

def driving_robot(mode: Mode, *, forward: bool = True, radius: int = 32767) -> Robot:
    """Return a robot on a table, far from its edge, that drives."""
    robot = Robot(mode, world=shipped('table'))
    robot.say(oi.Drive(velocity=100 if forward else -100, radius=radius))
    robot.run(0.5)
    assert robot.mode is mode
    return robot


@pytest.mark.parametrize('sensor', [
    'cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right'])
def test_safe_ends_on_a_cliff_while_moving_forward(sensor: str) -> None:
    robot = driving_robot(Mode.SAFE)
    robot.body.force(**{sensor: 1})
    robot.slots()
    assert robot.mode is Mode.PASSIVE
    assert robot.wheels == (0, 0)


@pytest.mark.parametrize(('radius', 'ends'), [
    *((small, True) for small in (1, -1, 100, -164)),
    *((large, False) for large in (32767, -32768, 166, -500))])
def test_safe_ends_on_a_cliff_while_moving_backward_with_a_small_radius_only(
        radius: int, ends: bool) -> None:
    robot = driving_robot(Mode.SAFE, forward=False, radius=radius)
    robot.body.force(cliff_left=1)
    robot.slots(1 if ends else 10)
    assert robot.mode is (Mode.PASSIVE if ends else Mode.SAFE)
    assert (robot.wheels == (0, 0)) is ends


@pytest.mark.parametrize('drop', ['drop_left', 'drop_right', 'drop_caster'])
@pytest.mark.parametrize('moving', [True, False])
def test_safe_ends_on_a_wheel_drop_on_any_wheel(drop: str, moving: bool) -> None:
    robot = Robot(Mode.SAFE)
    if moving:
        robot.say(GENTLE)
    robot.run(0.5)
    robot.body.force(**{drop: 1})
    robot.slots()
    assert robot.mode is Mode.PASSIVE


# Mode Commands.

def test_safe_turns_off_all_leds() -> None:
    robot = Robot(Mode.FULL)
    robot.say(oi.Leds(bits=10, color=255, intensity=255))
    assert robot.create.lights == (10, 255, 255)
    robot.say(oi.Safe())
    assert robot.create.lights == (0, 0, 0)


def test_in_full_create_executes_any_command_even_over_a_cliff_or_with_a_charger() -> None:
    robot = Robot(Mode.FULL, world=parse('cliff -9 -9 9 -9 9 9 -9 9', 'pit'))
    robot.body.plug_charger(True)
    robot.say(oi.DriveDirect(right=100, left=50))
    robot.run(1)
    assert robot.wheels == (100, 50)
    assert robot.mode is Mode.FULL


# Open Interface Command Reference.

def test_a_command_that_the_mode_forbids_still_takes_its_data_bytes() -> None:
    robot = Robot(Mode.PASSIVE)
    robot.say(bytes([145, 132, 132, 132, 132]), bytes([140, 0, 1, 132, 132]))
    assert robot.mode is Mode.PASSIVE


# Actuator Commands, and the packets that report on them (36, 37, 39 to 42).


ONE_NOTE, OTHER_NOTE = (Note(60, 32),), (Note(72, 64), Note(0, 64), Note(74, 64))


@pytest.fixture
def robot() -> Robot:
    """Return a robot in Full mode on endless floor."""
    return Robot(Mode.FULL)


# Drive and Drive Direct.

@pytest.mark.parametrize(('sent', 'speed', 'rate'), [
    ('137 255 56 1 244', -0.2, -0.2 / 0.5),  # the manual's example
    ('137 0 200 128 0', 0.2, 0.0), ('137 0 200 127 255', 0.2, 0.0), ('137 0 200 0 0', 0.2, 0.0),
    ('137 0 100 255 255', 0.0, -0.1 / 0.129), ('137 0 100 0 1', 0.0, 0.1 / 0.129),
    ('137 0 200 35 40', 0.2, 0.1), ('137 0 200 220 216', 0.2, -0.1),  # 2 m is the longest radius
    ('137 1 244 0 129', 0.25, 0.5 / 0.258),  # the outer wheel cannot run at 1 m/s
    ('145 0 200 255 156', 0.05, 0.3 / 0.258)])
def test_the_wheels_turn_as_the_manual_says(
        robot: Robot, sent: str, speed: float, rate: float) -> None:
    robot.say(vectors.octets(sent))
    robot.run(1)
    truth = robot.body.truth()
    assert (truth.speed, truth.rate) == pytest.approx((speed, rate), abs=1e-6)


@pytest.mark.parametrize(('asked', 'got'), [(32767, 500), (501, 500), (-501, -500)])
def test_a_velocity_out_of_range_is_clamped(robot: Robot, asked: int, got: int) -> None:
    word = asked.to_bytes(2, signed=True)
    robot.say(b'\x89' + word + b'\x7f\xff', b'\x91' + word + word)
    assert robot.read('requested_velocity') == got
    assert robot.read('requested_right_velocity') == got
    assert robot.read('requested_left_velocity') == got


def test_drive_and_drive_direct_report_in_their_own_packets(robot: Robot) -> None:
    robot.say(oi.Drive(velocity=120, radius=-340), oi.DriveDirect(right=56, left=-78))
    assert robot.ask(39, 40, 41, 42) == bytes([0, 120, 254, 172, 0, 56, 255, 178])


# LEDs, low side drivers, Send IR.

@pytest.mark.parametrize(('sent', 'name', 'value'), [
    ('139 8 0 128', 'lights', (oi.LedBits.ADVANCE, 0, 128)),
    ('144 32 0 128', 'duties', (128, 0, 32)), ('138 7 138 2', 'duties', (0, 128, 0)),
    ('144 129 0 0', 'duties', (0, 0, 0)), ('151 200 151 0', 'infrared_sent', deque([200, 0]))])
def test_the_manuals_examples_set_what_they_say_and_what_is_out_of_range_sets_nothing(
        robot: Robot, sent: str, name: str, value: object) -> None:
    robot.say(vectors.octets(sent))
    assert getattr(robot.create.actuators, name) == value


@pytest.mark.parametrize('masks', [True, False])
def test_whether_bits_without_a_meaning_count_is_a_guess_with_a_switch(masks: bool) -> None:
    """139 25 0 128 was seen to light Advance."""
    robot = Robot(Mode.FULL, guesses=Guesses(mask_bits=masks))
    robot.say(bytes([139, 25, 0, 128]), bytes([138, 0xf9]), bytes([147, 0xfc]))
    state = robot.create.actuators
    before = (oi.LedBits(0), 0, 0), (0, 0, 0), 0
    after = (oi.LedBits.ADVANCE, 0, 128), (128, 0, 0), 4
    assert (state.lights, state.duties, state.outputs) == (after if masks else before)


# Digital Outputs.


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


@pytest.mark.parametrize(('number', 'sounds'), [
    (30, False), (31, True), (127, True), (128, False), (0, False), (255, False)])
def test_notes_outside_the_range_of_31_to_127_are_rests(
        robot: Robot, number: int, sounds: bool) -> None:
    robot.say(oi.Song(number=0, notes=(Note(number, 64),)), oi.PlaySong(number=0))
    assert robot.create.note == (number if sounds else oi.REST)
    assert robot.read('song_playing')


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
