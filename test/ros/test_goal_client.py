# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals for programs of a few lines, and the example that drives a square by them."""

from functools import partial
from re import fullmatch
import signal

from create_oi_msgs.action import DriveDistance, NavigateToPosition
from geometry_msgs.msg import Point, PoseStamped
import pytest

from create_oi_ros.ros.goal_client import filled, GoalFailed
from create_oi_ros.sim.world import parse, World
from support.ros import Program, Robot, Scene, scene

FAILS = """
from create_oi_ros.ros.goal_client import GoalClient, GoalFailed

with GoalClient() as robot:
    for name, goal in (('fly', {}), ('drive_distance', {'distance': 5000.0}),
                       ('undock', {})):
        try:
            robot.do(name, **goal)
        except GoalFailed as why:
            print(why, flush=True)
    print(robot.do('drive_distance', distance=0.05).success, flush=True)
"""


def test_whole_numbers_are_taken_for_floats_also_inside_a_message():
    assert filled(DriveDistance.Goal(check_fields=True), {'distance': 1}, 'x').distance == 1.0
    there = PoseStamped(check_fields=False)
    there.pose.position = Point(check_fields=False)
    there.pose.position.x = 1
    goal = filled(NavigateToPosition.Goal(check_fields=True), {'goal_pose': there}, 'x')
    assert isinstance(goal.goal_pose.pose.position.x, float)
    assert goal.goal_pose.pose.position.x == 1.0


@pytest.mark.parametrize(('fields', 'words'), [
    ({'dist': 0.1}, "drive_distance has no field 'dist'; there are distance, max_trans"),
    ({'distance': '0.1'}, "distance = '0.1'; allowed is a value of type float"),
    ({'distance': True}, 'distance = True; allowed is a value of type float'),
    ({'distance': 1e40}, 'type float'),
    ({'time_allowance': 10}, 'time_allowance = 10; .* type builtin_interfaces/Duration'),
])
def test_a_field_that_does_not_exist_or_fit_is_refused(fields, words):
    with pytest.raises(GoalFailed, match=words):
        filled(DriveDistance.Goal(check_fields=True), fields, 'drive_distance')


@pytest.fixture
def stage(tmp_path):
    """Return an empty scene."""
    with scene(tmp_path) as made:
        yield made


def ready(stage: Scene, world: World | None = None) -> Robot:
    """Start a robot and its node; return the robot once it answers."""
    robot = stage.robot(world=world)
    node = stage.node(robot.link)
    stage.ros.until(lambda: 'robot answers' in node.output, 'the robot answers')
    return robot


def has_printed(program: Program, count: int) -> bool:
    """Return whether a program has printed so many lines."""
    return len(program.printed) >= count


def test_the_example_drives_a_square(stage):
    robot = ready(stage)
    example = stage.example('square.py')
    for count in range(1, 9):
        stage.ros.until(partial(has_printed, example, count), f'goal {count}')
    assert example.ended() == 0
    assert [line.split()[0] for line in example.printed] == ['drove', 'turned'] * 4
    pose = robot.body.truth().pose
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((0.0, 0.0, 0.0), abs=0.08)


def test_the_example_ends_with_the_reason_where_something_is_in_the_way(stage):
    ready(stage, parse('start 0 0 0\nwall 0.3 -1 0.3 1', 'wall'))
    example = stage.example('square.py')
    assert example.ended() == 1
    assert fullmatch(
        r'drive_distance: stopped after 0\.\d\d m; the bumper is pressed in front: '
        r'drive backwards or turn away\n', example.output)


def test_a_goal_that_fails_says_why_and_the_next_one_is_done(stage):
    ready(stage)
    script = stage.folder / 'fails.py'
    script.write_text(FAILS)
    program = stage.script(script)
    assert program.ended() == 0
    unknown, malformed, undocked, done = program.printed
    assert unknown.startswith("no action 'fly'; there are drive_distance, ")
    assert malformed == (
        'drive_distance: rejected as malformed; distance = 5000 m; allowed: -1000 to 1000\n')
    assert undocked == (
        'undock: not started; the robot is on no dock: there is nothing to leave\n')
    assert done == 'True\n'


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_cancels_the_goal_and_ends_the_program_with_one_line(stage, number):
    robot = ready(stage)
    example = stage.example('square.py')
    stage.ros.until(lambda: robot.body.truth().speed > 0.05, 'the robot moves')
    example.send(number)
    assert example.ended() == 1
    assert fullmatch(
        r'drive_distance: stopped after 0\.\d\d m; canceled\n', example.output)
    stage.ros.until(lambda: robot.create.actuators.wheels == (0, 0), 'the wheels stand')


def test_without_a_driver_the_program_ends_with_a_sentence(stage):
    example = stage.example('square.py')
    assert example.ended() == 1
    said, ended = example.printed
    assert said.startswith('goal_client: waits for the action drive_distance in ROS domain '
                           f'{stage.domain}; on this computer ')
    assert ended == f'drive_distance: no driver was found in ROS domain {stage.domain}\n'
