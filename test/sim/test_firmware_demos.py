# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The ten demos of the simulated Create, by what can be seen (manual: Demo Commands)."""

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
    assert {'north': any(pose.y > 0.7 for pose in poses), 'south': any(pose.y < -0.7 for pose in
            poses), 'east': any(pose.x > 1.2 for pose in poses), 'west': any(pose.x < -1.2 for
            pose in poses)} == dict.fromkeys(('north', 'south', 'east', 'west'), True)
    late = poses[600:]
    beside = [pose for pose in late if abs(pose.x) > 1.1 or abs(pose.y) > 0.6]
    assert len(beside) > 0.95 * len(late)


def test_figure_eight_drives_circles_to_both_sides() -> None:
    robot = performing(DemoNumber.DRIVE_FIGURE_EIGHT)
    poses = track(robot, 60)
    assert max(pose.y for pose in poses) > 0.5
    assert min(pose.y for pose in poses) < -0.5
    assert abs(max(pose.y for pose in poses) + min(pose.y for pose in poses)) < 0.1


def test_wimp_drives_forward_when_pushed_from_behind() -> None:
    robot = performing(DemoNumber.WIMP)
    robot.run(10)
    assert robot.body.truth().travelled == 0
    robot.body.push(speed=0.1, rate=0, seconds=0.2)
    robot.run(10)
    assert robot.body.truth().travelled > 0.4


def test_home_spins_to_locate_a_virtual_wall_drives_toward_it_and_stops_at_the_obstacle() -> None:
    robot = performing(DemoNumber.HOME, parse('wall 1 -2 1 2', 'wall'))
    robot.run(3)
    assert robot.body.truth().pose[:2] == pytest.approx((0, 0), abs=1e-6)
    turned = abs(robot.body.truth().turned)
    assert turned > 1
    robot.body.place(Pose(0, 0, 0))
    robot.body.force(virtual_wall=1)
    robot.run(10)
    assert robot.create.demo is None
    assert (robot.speed, robot.body.truth().pose.x) == pytest.approx((0, 0.835), abs=0.01)


def test_tag_drives_into_one_virtual_wall_turns_around_and_drives_to_the_next() -> None:
    world = parse('wall 1 -2 1 2\nwall -1 -2 -1 2\n'
                  'virtual_wall 0.95 0 180 0.8\nvirtual_wall -0.95 0 0 0.8\nstart 0.5 0 0', 'two')
    robot = performing(DemoNumber.TAG, world)
    poses = track(robot, 60)
    east = [n for n, pose in enumerate(poses) if pose.x > 0.8]
    west = [n for n, pose in enumerate(poses) if pose.x < -0.8]
    assert east
    assert west
    assert robot.create.demo is DemoNumber.TAG


def test_pachelbel_plays_the_canon_in_sequence_when_cliff_sensors_are_activated() -> None:
    robot = performing(DemoNumber.PACHELBEL)
    heard = []
    for number in range(10):
        robot.run(1)
        assert robot.create.note == 0
        robot.body.force(seconds=0.1, **{('cliff_left', 'cliff_right')[number % 2]: 1})
        robot.slots(2)
        heard.append(robot.create.note)
    assert heard == [78, 76, 74, 73, 71, 69, 71, 73, 74, 73]
    assert robot.wheels == (0, 0)


@pytest.mark.parametrize(('bumper', 'chord'), [
    ({}, {55, 59, 62, 67}), ({'bump_left': 1}, {62, 66, 69, 73}),
    ({'bump_right': 1}, {62, 66, 69, 73}),
    ({'bump_left': 1, 'bump_right': 1}, {60, 64, 67, 72})])
def test_banjo_plays_a_note_of_a_chord_for_each_cliff_sensor(
        bumper: dict[str, int], chord: set[int]) -> None:
    robot = performing(DemoNumber.BANJO)
    robot.body.force(**bumper)
    heard = set()
    for sensor in ('cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right'):
        robot.run(1)
        robot.body.force(seconds=0.1, **{sensor: 1})
        robot.slots(2)
        heard.add(robot.create.note)
    assert heard == chord
