# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The demos of the simulated Create, by what can be seen (manual: Demo Commands)."""

import math

import pytest

from create_oi_ros import oi
from create_oi_ros.oi import DemoNumber, Mode
from create_oi_ros.sim.world import parse, Pose, shipped, World
from support.robot import Robot


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


def cells(poses: list[Pose]) -> set[tuple[int, int]]:
    """Return the squares of 25 cm that were visited."""
    return {(math.floor(pose.x / 0.25), math.floor(pose.y / 0.25)) for pose in poses}


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
    visited = cells(track(robot, 200))
    assert len(visited) > (25 if name == 'room' else 12)
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
