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

STARTED = (Mode.PASSIVE, Mode.SAFE, Mode.FULL)
"""Places on the shipped table, which ends at x = 1."""


# iRobot Create Open Interface Modes.

def test_when_first_supplied_the_oi_is_in_off_mode() -> None:
    assert Robot().mode is Mode.OFF


@pytest.mark.parametrize('command', [kind for kind in oi.COMMANDS if kind is not oi.Start])
def test_when_off_it_obeys_nothing_but_start(command: type[oi.Command]) -> None:
    robot = Robot()
    size = command.size(bytes([command.opcode, 1, 1, 1]))
    assert robot.say(bytes([command.opcode] + [1] * (size - 1))) == b''
    assert robot.slots(10) == b''
    assert robot.mode is Mode.OFF
    assert robot.create.demo is None
    assert robot.wheels == (0, 0)


@pytest.mark.parametrize('before', STARTED)
@pytest.mark.parametrize(('command', 'after'), [
    (oi.Start(), Mode.PASSIVE), (oi.Control(), Mode.SAFE), (oi.Safe(), Mode.SAFE),
    (oi.Full(), Mode.FULL)])
def test_you_can_switch_between_modes_at_any_time(
        before: Mode, command: oi.Command, after: Mode) -> None:
    robot = Robot(before)
    robot.say(command)
    assert robot.mode is after
    assert robot.read('oi_mode') is after


# Passive Mode.

@pytest.mark.parametrize('mode', STARTED)
@pytest.mark.parametrize('command', [
    oi.Spot(), oi.Cover(), oi.CoverAndDock(), *(oi.Demo(demo=n) for n in oi.DemoNumber)])
def test_upon_a_demo_command_the_oi_enters_into_passive_mode(
        mode: Mode, command: oi.Command) -> None:
    robot = Robot(mode)
    robot.say(command)
    assert robot.mode is Mode.PASSIVE


def test_in_passive_you_can_request_and_receive_sensor_data() -> None:
    robot = Robot(Mode.PASSIVE)
    assert robot.say(oi.Sensors(packet=35)) == b'\x01'
    robot.say(oi.Stream(packets=(35,)))
    assert robot.slots() == bytes([19, 2, 35, 1, 256 - 19 - 2 - 35 - 1])


@pytest.mark.parametrize('command', [
    oi.Drive(velocity=100, radius=32767), oi.DriveDirect(right=100, left=100),
    oi.Leds(bits=8, color=0, intensity=128), oi.DigitalOutputs(bits=7),
    oi.LowSideDrivers(bits=7), oi.PwmLowSideDrivers(driver_2=1, driver_1=1, driver_0=1),
    oi.SendIr(byte=1), oi.PlaySong(number=0)])
def test_in_passive_you_cannot_change_the_actuators(command: oi.Command) -> None:
    robot = Robot(Mode.PASSIVE)
    robot.say(oi.Song(number=0, notes=(oi.Note(60, 64),)), command)
    actuators = robot.create.actuators
    robot.run(1.0)
    assert (robot.wheels, robot.speed) == ((0, 0), 0)
    assert (actuators.duties, actuators.outputs, actuators.lights.bits) == ((0, 0, 0), 0, 0)
    assert not actuators.infrared_sent
    assert not robot.read('song_playing')


def test_in_passive_the_battery_is_charged() -> None:
    robot = Robot(Mode.PASSIVE)
    robot.body.plug_charger(True)
    before = robot.read('battery_charge')
    robot.run(60)
    assert robot.read('charging_state') is oi.ChargingState.FULL_CHARGING
    assert robot.read('battery_charge') > before


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


def test_safe_stops_before_it_falls_off_a_real_edge() -> None:
    robot = driving_robot(Mode.SAFE)
    robot.run(30)
    assert robot.mode is Mode.PASSIVE
    assert robot.body.truth().pose.x < 1
    assert not robot.body.sense().drop_left


@pytest.mark.parametrize('radius', [1, -1, 100, -164])
def test_safe_ends_on_a_cliff_while_moving_backward_with_a_small_radius(radius: int) -> None:
    robot = driving_robot(Mode.SAFE, forward=False, radius=radius)
    robot.body.force(cliff_left=1)
    robot.slots()
    assert robot.mode is Mode.PASSIVE


@pytest.mark.parametrize('radius', [32767, -32768, 166, -500])
def test_safe_goes_on_over_a_cliff_while_moving_backward_otherwise(radius: int) -> None:
    robot = driving_robot(Mode.SAFE, forward=False, radius=radius)
    robot.body.force(cliff_left=1)
    robot.slots(10)
    assert robot.mode is Mode.SAFE
    assert robot.wheels != (0, 0)


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


def test_safe_ends_when_a_charger_is_plugged_in_and_powered() -> None:
    robot = Robot(Mode.SAFE)
    robot.body.plug_charger(True)
    robot.slots()
    assert robot.mode is Mode.PASSIVE


def test_start_ends_a_demo() -> None:
    robot = Robot(Mode.PASSIVE)
    robot.say(oi.Spot(), oi.Start())
    assert robot.create.demo is None


# Mode Commands.

def test_safe_turns_off_all_leds() -> None:
    robot = Robot(Mode.FULL)
    robot.say(oi.Leds(bits=10, color=255, intensity=255))
    assert robot.create.lights == (10, 255, 255)
    robot.say(oi.Safe())
    assert robot.create.lights == (0, 0, 0)


@pytest.mark.parametrize('mode', STARTED)
def test_the_effect_of_control_is_identical_to_safe(mode: Mode) -> None:
    robot, other = Robot(mode), Robot(mode)
    robot.say(oi.Control())
    other.say(oi.Safe())
    for each in (robot, other):
        each.say(oi.Leds(bits=2, color=0, intensity=0), GENTLE)
        each.body.force(drop_left=1)
    assert robot.run(1) == other.run(1)
    assert robot.mode is other.mode is Mode.PASSIVE
    assert robot.ask(6) == other.ask(6)


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


def test_the_last_drive_holds_for_ever() -> None:
    robot = Robot(Mode.SAFE)
    robot.say(GENTLE)
    robot.run(60)
    assert robot.speed == pytest.approx(0.1)
    assert robot.body.truth().travelled == pytest.approx(6, rel=0.002)
