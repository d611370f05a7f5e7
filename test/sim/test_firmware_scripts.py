# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Scripts, waits and demos of the simulated Create, one test for each sentence of the manual.

Sections Script Commands, Wait Commands and Demo Commands.
"""

import math

import pytest

from create_oi_ros import oi
from create_oi_ros.oi import DemoNumber, Mode
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import parse, Pose, shipped, World
from support.robot import GENTLE, Robot

PLAY, SHOW = bytes([153]), bytes([154])
LOOP = bytes([152, 3, 151, 77, 153])
AFTER = bytes([139, 8, 0, 0])
"""Lights the Advance LED, which shows that a wait is over."""


@pytest.fixture
def robot() -> Robot:
    """Return a robot in Full mode on endless floor."""
    return Robot(Mode.FULL)


def lit(robot: Robot) -> bool:
    """Return whether AFTER was obeyed."""
    return robot.create.lights.bits == oi.LedBits.ADVANCE


# Script, Play Script, Show Script.

def test_a_script_can_be_up_to_100_bytes_long_and_is_shown_behind_its_length(
        robot: Robot) -> None:
    longest = bytes([100, *range(100)])
    robot.say(bytes([152]) + longest)
    assert robot.say(SHOW) == longest
    robot.say(bytes([152, 101] + [131] * 101))
    assert robot.say(SHOW) == longest


def test_show_script_first_halts_the_sensor_stream(robot: Robot) -> None:
    robot.say(bytes([148, 1, 7]))
    assert len(robot.slots()) == 5
    assert robot.say(SHOW) == b'\0'
    assert robot.slots(10) == b''
    robot.say(bytes([150, 1]))
    assert len(robot.slots(2)) == 10


def test_to_make_a_script_loop_forever_use_play_script_as_the_last_command(robot: Robot) -> None:
    robot.say(LOOP, PLAY)
    robot.run(0.15)
    assert 9 <= list(robot.create.actuators.infrared_sent).count(77) <= 11
    robot.create.power(False, robot.now)
    robot.create.power(True, robot.now)
    robot.run(4)
    robot.say(oi.Start())
    assert robot.mode is Mode.PASSIVE


def test_between_the_rounds_of_a_script_that_plays_itself_the_host_is_obeyed(robot: Robot) -> None:
    robot.say(LOOP, PLAY, GENTLE)
    robot.run(0.1)
    assert robot.wheels == (100, 100)
    assert robot.ask(35) == b'\3'
    robot.say(bytes([152, 0]))
    sent = list(robot.create.actuators.infrared_sent)
    robot.run(1)
    assert list(robot.create.actuators.infrared_sent) == sent


def test_that_a_script_that_plays_itself_is_deaf_is_a_guess_with_a_switch() -> None:
    robot = Robot(Mode.FULL, guesses=Guesses(loop_listens=False))
    robot.say(LOOP, PLAY)
    robot.run(0.1)
    robot.say(oi.Start(), GENTLE, bytes([152, 0]))
    robot.run(1)
    assert (robot.mode, robot.wheels) == (Mode.FULL, (0, 0))
    assert robot.create.actuators.infrared_sent.count(77) > 50


# Waiting.

@pytest.mark.parametrize('wait', [bytes([155, 255]), bytes([156, 1, 0]), bytes([157, 0, 90]),
                                  bytes([158, 5])])
def test_while_waiting_create_does_not_react_to_serial_inputs(robot: Robot, wait: bytes) -> None:
    robot.say(GENTLE, wait)
    robot.say(oi.DriveDirect(right=0, left=0))
    assert robot.say(oi.Sensors(packet=35)) == b''
    robot.run(0.5)
    assert robot.say(oi.Start()) == b''
    assert (robot.mode, robot.wheels) == (Mode.FULL, (100, 100))
    assert robot.create.waiting


@pytest.mark.parametrize('script', [bytes([152, 2, 155, 10, 153]), bytes([155, 10])])
def test_bytes_behind_a_wait_are_lost_by_a_robot_without_a_queue(script: bytes) -> None:
    robot = Robot(Mode.FULL, guesses=Guesses(wait_queue=0))
    robot.say(script, GENTLE)
    robot.run(0.5)
    robot.say(GENTLE)
    robot.run(2)
    assert robot.wheels == (0, 0)
    robot.say(GENTLE)
    assert robot.wheels == (100, 100)


@pytest.mark.parametrize('queue', [0, 256])
def test_a_request_during_a_wait_is_answered_at_once_by_another_guess(queue: int) -> None:
    robot = Robot(Mode.FULL, guesses=Guesses(wait_answers=True, wait_queue=queue))
    assert robot.say(bytes([155, 10, 149])) == b''
    assert robot.say(bytes([1, 35]), GENTLE, bytes([142])) == b'\3'
    assert robot.say(bytes([35])) == b'\3'
    robot.say(bytes([139, 8]))
    robot.run(1.1)
    assert robot.wheels == ((100, 100) if queue else (0, 0))
    robot.say(bytes([0, 0]))
    assert lit(robot)


def test_a_full_queue_loses_bytes() -> None:
    robot = Robot(Mode.FULL, guesses=Guesses(wait_queue=7))
    robot.say(bytes([155, 10]), GENTLE, AFTER)
    robot.run(1.1)
    assert robot.wheels == (100, 100)
    assert not lit(robot)
    robot.say(bytes([0, 0]))  # the end of AFTER, of which the queue took half
    assert lit(robot)


def test_while_waiting_create_does_not_react_to_buttons() -> None:
    robot = Robot(Mode.PASSIVE)
    robot.say(bytes([155, 50]))
    robot.body.force(play=1, seconds=0.2)
    robot.run(1)
    assert robot.create.demo is None


def test_while_waiting_a_safety_stop_still_enters_passive() -> None:
    robot = Robot(Mode.SAFE)
    script = bytes([145, 0, 100, 0, 100, 158, 22, 151, 1])
    robot.say(bytes([152, len(script)]) + script, PLAY)
    robot.run(1)
    assert robot.create.waiting
    robot.body.force(cliff_left=1)
    robot.slots(2)
    assert (robot.mode, robot.create.waiting) == (Mode.PASSIVE, False)


@pytest.mark.parametrize('goes_on', [True, False])
def test_whether_the_stream_goes_on_while_waiting_is_a_guess_with_a_switch(
        goes_on: bool) -> None:
    robot = Robot(Mode.FULL, guesses=Guesses(stream_while_waiting=goes_on))
    robot.say(bytes([148, 1, 7]), bytes([155, 10]))
    assert bool(robot.run(0.5)) is goes_on
    robot.run(0.6)
    assert len(robot.slots(2)) == 10


# Wait Time.

@pytest.mark.parametrize(('tenths', 'seconds'), [(1, 0.105), (5, 0.510), (10, 1.005), (30, 3.0)])
def test_wait_time_is_in_tenths_of_a_second_with_a_resolution_of_15_ms(
        robot: Robot, tenths: int, seconds: float) -> None:
    script = bytes([155, tenths]) + AFTER
    robot.say(bytes([152, len(script)]) + script, PLAY)
    robot.run(seconds - 0.005)
    assert not lit(robot)
    robot.run(0.005)
    assert lit(robot)


# Wait Distance, Wait Angle.

@pytest.mark.parametrize(('right', 'left', 'wait', 'not_yet', 'then'), [
    (100, 100, oi.WaitDistance(distance=200), 1.9, 0.25),
    (-100, -100, oi.WaitDistance(distance=-200), 1.9, 0.25),
    (100, -100, oi.WaitAngle(angle=90), 2.0, 0.2),
    (-100, 100, oi.WaitAngle(angle=-90), 2.0, 0.2)])
def test_a_wait_ends_after_a_way_or_a_turn_in_its_direction(
        robot: Robot, right: int, left: int, wait: oi.Command, not_yet: float,
        then: float) -> None:
    script = oi.DriveDirect(right=right, left=left).encode() + wait.encode() + AFTER
    robot.say(bytes([152, len(script)]) + script, PLAY)
    robot.run(not_yet)
    assert not lit(robot)
    robot.run(then)
    assert lit(robot)


def test_wait_distance_does_not_end_on_travel_the_other_way(robot: Robot) -> None:
    robot.say(oi.DriveDirect(right=-100, left=-100), oi.WaitDistance(distance=100))
    robot.run(60)
    assert robot.create.waiting


@pytest.mark.parametrize(('left', 'wait', 'packet'), [
    (100, oi.WaitDistance(distance=0), 19), (-100, oi.WaitAngle(angle=0), 20)])
def test_a_wait_resets_its_variable(
        robot: Robot, left: int, wait: oi.Command, packet: int) -> None:
    robot.say(oi.DriveDirect(right=100, left=left))
    robot.run(1)
    robot.say(wait)
    assert robot.ask(packet) == b'\0\0'


# Wait Event.

EVENTS = {1: 'drop_caster', 2: 'drop_caster', 3: 'drop_left', 4: 'drop_right', 5: 'bump_left',
          6: 'bump_left', 7: 'bump_right', 8: 'virtual_wall', 9: 'wall', 10: 'cliff_front_left',
          11: 'cliff_left', 12: 'cliff_front_left', 13: 'cliff_front_right', 14: 'cliff_right',
          15: 'home_base', 16: 'advance', 17: 'play', 18: 'digital_input_0',
          19: 'digital_input_1', 20: 'digital_input_2', 21: 'digital_input_3'}


@pytest.mark.parametrize(('event', 'sensor'), EVENTS.items())
def test_wait_event_waits_for_the_event_or_its_inverse(
        robot: Robot, event: int, sensor: str) -> None:
    robot.say(bytes([158, event]))
    robot.run(1)
    assert robot.create.waiting
    robot.body.force(**{sensor: 1})
    robot.slots()
    assert not robot.create.waiting
    robot.say(bytes([158, 256 - event]))
    robot.run(1)
    assert robot.create.waiting
    robot.body.force(**{sensor: 0})
    robot.slots()
    assert not robot.create.waiting


@pytest.mark.parametrize('event', [0, 23, 128, 233])
def test_an_event_that_is_not_there_is_not_waited_for(robot: Robot, event: int) -> None:
    robot.say(bytes([158, event]), AFTER)
    assert lit(robot)


# Demo Commands, by what can be seen.


def performing(demo: DemoNumber, world: World | None = None, *, seed: int = 0) -> Robot:
    """Return a robot that has just been told to start a demo."""
    robot = Robot(Mode.PASSIVE, world=world, seed=seed)
    robot.say(oi.Demo(demo=demo))
    assert robot.create.demo is demo
    return robot


def track(robot: Robot, seconds: float) -> list[Pose]:
    """Let time pass; return where the robot was, once a tenth of a second."""
    poses = []
    for _ in range(round(seconds * 10)):
        robot.run(0.1)
        poses.append(robot.body.truth().pose)
    return poses


@pytest.mark.parametrize(('command', 'demo'), [
    (oi.Cover(), DemoNumber.COVER), (oi.CoverAndDock(), DemoNumber.COVER_AND_DOCK),
    (oi.Spot(), DemoNumber.SPOT_COVER)])
def test_three_demos_have_opcodes_of_their_own(command: oi.Command, demo: DemoNumber) -> None:
    robot = Robot(Mode.FULL)
    robot.say(command)
    assert robot.create.demo is demo


@pytest.mark.parametrize('demo', [each for each in DemoNumber if each is not DemoNumber.ABORT])
@pytest.mark.parametrize('command', [oi.Demo(demo=-1), oi.Safe(), oi.Full(), oi.Start()])
def test_abort_and_a_change_of_mode_stop_the_demo(demo: DemoNumber, command: oi.Command) -> None:
    robot = performing(demo, shipped('room'))
    robot.run(2)
    robot.say(command)
    robot.run(1)
    assert (robot.create.demo, robot.speed) == (None, 0)


@pytest.mark.parametrize('demo', [10, 127, 128, 254])
def test_a_demo_that_is_not_there_is_ignored(demo: int) -> None:
    robot = Robot(Mode.SAFE)
    robot.say(bytes([136, demo]))
    assert (robot.create.demo, robot.mode) == (None, Mode.SAFE)


@pytest.mark.parametrize('sensor', ['drop_left', 'internal_charger'])
def test_a_wheel_drop_or_a_charger_ends_a_demo(sensor: str) -> None:
    robot = performing(DemoNumber.DRIVE_FIGURE_EIGHT)
    robot.run(1)
    robot.body.force(**{sensor: 1})
    robot.run(1)
    assert (robot.create.demo, robot.speed, robot.mode) == (None, 0, Mode.PASSIVE)


@pytest.mark.parametrize('name', ['room', 'table'])
def test_cover_attempts_to_cover_an_entire_room_and_falls_off_no_table(name: str) -> None:
    robot = performing(DemoNumber.COVER, shipped(name))
    squares = {(math.floor(pose.x / 0.25), math.floor(pose.y / 0.25))
               for pose in track(robot, 200)}
    assert len(squares) > (25 if name == 'room' else 12)
    assert robot.create.demo is DemoNumber.COVER


@pytest.mark.parametrize(('name', 'seed'), [('room', 0), ('apartment', 1)])
def test_cover_and_dock_uses_the_infrared_signal_to_dock_and_recharge(
        name: str, seed: int) -> None:
    robot = performing(DemoNumber.COVER_AND_DOCK, shipped(name), seed=seed)
    robot.run(300)
    assert robot.create.demo is None
    assert robot.read('charging_sources') is oi.ChargingSources.HOME_BASE
    assert robot.read('charging_state') is oi.ChargingState.FULL_CHARGING


def test_spot_cover_spirals_outward_then_inward() -> None:
    robot = performing(DemoNumber.SPOT_COVER)
    poses = track(robot, 95)
    far = [math.hypot(pose.x, pose.y) for pose in poses]
    widest = far.index(max(far))
    assert len(far) * 0.25 < widest < len(far) * 0.75
    assert 0.4 < max(far) < 1.2
    assert far[-1] < 0.35
    assert robot.create.demo is None


def test_mouse_drives_along_the_wall_around_the_circumference_of_the_room() -> None:
    robot = performing(DemoNumber.MOUSE, parse('box -1.5 -1 1.5 1', 'hall'))
    poses = track(robot, 240)
    across, along = zip(*((pose.x, pose.y) for pose in poses))
    assert min(across) < -1.2 and max(across) > 1.2
    assert min(along) < -0.7 and max(along) > 0.7
    late = poses[600:]
    beside = [pose for pose in late if abs(pose.x) > 1.1 or abs(pose.y) > 0.6]
    assert len(beside) > 0.95 * len(late)


@pytest.mark.parametrize('demo', [
    DemoNumber.WIMP, DemoNumber.HOME, DemoNumber.TAG, DemoNumber.PACHELBEL, DemoNumber.BANJO])
def test_a_demo_that_is_not_simulated_plays_and_the_robot_stands(demo: DemoNumber) -> None:
    robot = performing(demo, parse('wall 1 -2 1 2', 'wall'))
    robot.body.force(virtual_wall=1, cliff_left=1)
    robot.run(10)
    assert (robot.create.demo, robot.body.truth().travelled) == (demo, 0)
    robot.say(oi.Demo(demo=DemoNumber.ABORT))
    assert robot.create.demo is None
