# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The simulated Create's modes, one test for each sentence of the manual that says what it does.

Sections are the manual's: iRobot Create Open Interface Modes, Getting Started Commands, Mode
Commands, Open Interface Command Reference.
"""

import pytest

from create_oi_ros import oi
from create_oi_ros.oi import Mode
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


SENSORS = ['cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right']


@pytest.mark.parametrize('sensor', SENSORS)
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
