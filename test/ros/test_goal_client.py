# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals for programs of a few lines, and the example that drives a square by them."""

from math import pi
from re import fullmatch
import signal

from create_oi_msgs.action import DriveDistance, NavigateToPosition
from create_oi_msgs.srv import DefineSong
from geometry_msgs.msg import Point, PoseStamped
import pytest

from create_oi_ros.ros.messages import filled
from support.ros import Program

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

ALONE = """
from create_oi_ros.ros import goal_client

goal_client.DISCOVERY_TIMEOUT = 3.0
with goal_client.GoalClient() as robot:
    try:
        robot.do('drive_distance', distance=0.3)
    except Exception as why:
        print(f'{type(why).__name__}: {why}', flush=True)
"""
"""As a user writes it; no driver is looked for as long as on a busy computer."""


def test_whole_numbers_are_taken_for_floats_also_inside_a_message():
    assert filled(DriveDistance.Goal(check_fields=True), {'distance': 1}, 'x').distance == 1.0
    there = PoseStamped(check_fields=False)
    there.pose.position = Point(check_fields=False)
    there.pose.position.x = 1
    goal = filled(NavigateToPosition.Goal(check_fields=True), {'goal_pose': there}, 'x')
    assert isinstance(goal.goal_pose.pose.position.x, float)
    assert goal.goal_pose.pose.position.x == 1.0


def test_whole_numbers_are_taken_for_floats_also_in_a_list():
    song = filled(DefineSong.Request(check_fields=True),
                  {'pitches': (60, 64), 'seconds': [1, 0.5]}, 'x')
    assert (list(song.pitches), list(song.seconds)) == ([60, 64], [1.0, 0.5])
    for wrong in ([True, 0.5], ['a'], 1, [10 ** 400]):
        with pytest.raises(ValueError, match='allowed is a value of type sequence<float>'):
            filled(DefineSong.Request(check_fields=True), {'seconds': wrong}, 'x')


@pytest.mark.parametrize(('fields', 'words'), [
    ({'dist': 0.1}, "drive_distance has no field 'dist'; allowed: distance, max_trans"),
    ({'distance': '0.1'}, "distance = '0.1'; allowed is a value of type float"),
    ({'distance': True}, 'distance = True; allowed is a value of type float'),
    ({'distance': 1e40}, 'type float'),
    ({'time_allowance': 10}, 'time_allowance = 10; .* type builtin_interfaces/Duration'),
])
def test_a_field_that_does_not_exist_or_fit_is_refused(fields, words):
    with pytest.raises(ValueError, match=words):
        filled(DriveDistance.Goal(check_fields=True), fields, 'drive_distance')


def said(program: Program) -> list[str]:
    """Return the lines of a program but for what it waits for, as on a busy computer."""
    return [line for line in program.printed if ': waits for ' not in line]


def test_the_example_drives_and_turns_until_ctrl_c_cancels_its_goal(ready):
    pose = ready.robot.body.truth

    def begun():
        """Start it; return it after a side and a corner, None where the computer stood still."""
        ready.renew()
        before, started = len(ready.node.output), ready.stage.example('square.py')
        ready.ros.until(lambda: len(said(started)) == 2 or not started.running(), 'a corner')
        moves = [line.split()[0] for line in said(started)]
        if moves != ['drove', 'turned'] and 'no frame for' in ready.node.output[before:]:
            return None
        assert moves == ['drove', 'turned'], started.output
        return started
    example = ready.ros.until(begun, 'a drive without a gap')
    assert (pose().pose.x, pose().pose.yaw) == pytest.approx((0.3, pi / 2), abs=0.05)
    ready.ros.until(lambda: pose().speed > 0.05, 'the second side')
    example.send(signal.SIGINT)
    assert example.ended() == 1
    assert fullmatch(
        r'drive_distance: stopped after 0\.\d\d m; canceled\n', example.printed[-1])
    ready.ros.until(lambda: ready.robot.standing, 'the wheels stand')


def test_a_goal_that_fails_says_why_and_the_next_one_is_done(ready):
    program = ready.stage.python('-c', FAILS)
    assert program.ended() == 0
    unknown, malformed, undocked, done = said(program)
    assert unknown.startswith("no action 'fly'; there are drive_distance, ")
    assert malformed == (
        'drive_distance: rejected as malformed; distance = 5000 m; allowed: -1000 to 1000\n')
    assert undocked == (
        'undock: not started; the robot is on no dock: there is nothing to leave\n')
    assert done == 'True\n'


def test_without_a_driver_the_program_ends_with_a_sentence(stage):
    program = stage.python('-c', ALONE)
    assert program.ended() == 0
    said, ended = program.printed
    assert said.startswith('goal_client: waits for the action drive_distance in ROS domain '
                           f'{stage.domain}; on this computer ')
    assert ended == ('GoalFailed: drive_distance: no driver offers /drive_distance in ROS domain '
                     f'{stage.domain}\n')
