# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Examples with a driver: what ros2 does, a node of your own, LEDs, a tune, two robots, a wall."""

import signal

from create_oi_msgs.msg import Mode
from nav_msgs.msg import Odometry
import pytest
import yaml

from create_oi_ros import oi
from create_oi_ros.sim.world import parse, Pose, shipped
from support.ros import Ready


@pytest.fixture(scope='module')
def shared(shared_stage):
    """Return a robot before a wall, and its driver."""
    return Ready(shared_stage, parse('start 0 0 0\nwall 0.4 -1 0.4 1', 'wall'))


def printed(stage, text, *arguments):
    """Run an example until it has printed a text, and end it by Ctrl-C."""
    program = stage.example(*arguments)
    stage.ros.until(lambda: text in program.output or not program.running(), program.output)
    assert text in program.output, program.output
    if program.running():
        program.send(signal.SIGINT)
    assert program.ended() == 0, program.output
    return program.output


def result(stage, *arguments):
    """Run an example to its end; return what it printed."""
    program = stage.example(*arguments)
    assert program.ended() == 0, program.output
    return program.output


def test_what_ros2_does_is_done_by_the_example(shared):
    listed = result(shared.stage, 'ros.py', 'list')
    assert '/odom ' in listed and 'create_oi_msgs/srv/SetMode' in listed
    echoed = printed(shared.stage, '---', 'ros.py', 'echo', '/mode')
    assert yaml.safe_load(echoed.partition('---')[0])['mode'] == Mode.SAFE
    full = yaml.safe_load(result(shared.stage, 'ros.py', 'call', '/set_mode', '{mode: 3}'))
    assert full['success'] is True and shared.robot.create.mode is oi.Mode.FULL
    assert 'success: true' in result(shared.stage, 'ros.py', 'call', '/set_mode', '{mode: 2}')
    assert 'successful: true' in result(
        shared.stage, 'ros.py', 'set', '/create', 'cmd_vel_timeout', '0.4')


MISTYPED = (
    (['echo', '/nothing'], 'nobody publishes /nothing: see list'),
    (['call', '/nothing'], 'nobody offers /nothing: see list'),
    (['call', '/set_mode', '{mod: 2}'], "has no field 'mod'; allowed: mode"),
    (['call', '/set_mode', '{mode'], "'{mode' is no YAML of the form '{field: value}'"),
    (['call', '/set_mode', '2'], "'2' is no YAML of the form '{field: value}'"),
    (['set', '/create', 'cmd_vel_timout', '1.0'], 'no parameter cmd_vel_timout; it has '),
    (['set', '/nobody', 'cmd_vel_timeout', '1.0'], 'no node /nobody is found: see list'))


def test_what_is_mistyped_is_said_in_a_line(shared):
    started = [(shared.stage.example('ros.py', *arguments), why) for arguments, why in MISTYPED]
    for program, why in started:
        assert program.ended() == 2
        assert why in program.output and 'Traceback' not in program.output


def test_a_node_of_ones_own_turns_away_from_a_wall(shared):
    printed(shared.stage, 'turned by 1.7', 'own_node.py')


def test_leds_blink(shared):
    program = shared.stage.example('leds.py')
    for led in (oi.LedBits.PLAY, oi.LedBits.ADVANCE, oi.LedBits.PLAY):
        shared.ros.until(lambda led=led: shared.robot.create.lights[0] == led, led.name)
    program.send(signal.SIGINT)
    assert program.ended() == 0, program.output


@pytest.mark.nightly
def test_a_long_tune_is_played(shared):
    assert 'the tune was played' in result(shared.stage, 'tune.py')


@pytest.mark.nightly
def test_two_robots_drive_a_square_each(stage):
    robots = [stage.program(
        'create_run', '--ros-args', '-r', f'__ns:=/{name}', '-p', f'odom_frame:={name}/odom',
        '-p', f'base_frame:={name}/base_footprint') for name in ('robot1', 'robot2')]
    for robot in robots:
        stage.ros.until(lambda robot=robot: 'robot answers' in robot.output, 'a robot')
    program = stage.example('two_robots.py')
    for count in range(1, 9):
        stage.ros.until(lambda count=count: len(program.printed) >= count, f'move {count}')
    assert program.ended() == 0, program.output


def test_the_program_ends_at_a_cliff_and_begins_again_where_the_robot_was_put(stage):
    robot = stage.robot(world=shipped('table'))
    stage.node(robot.link)
    odom = stage.ros.listen(Odometry, 'odom')
    example = stage.example('follow_wall.py')
    stage.ros.until(lambda: not example.running(), 'the cliff')
    assert example.ended() == 0
    assert 'the robot has left Safe mode, ' in example.output
    assert 'cliff' in example.output
    robot.soon(lambda: robot.body.place(Pose(0.0, 0.0, 0.0)))
    # The driver waits until the cliff has been gone for more than a second of frames.
    seen = len(odom)
    stage.ros.until(lambda: len(odom) > seen + 100)
    again = stage.example('follow_wall.py')
    stage.ros.until(lambda: odom[-1].twist.twist.linear.x > 0.1)
    assert again.running()
