# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Examples that need a driver: what ros2 does, a node of one's own, LEDs, a tune, two robots."""

import signal

import pytest

from create_oi_ros import oi
from create_oi_ros.sim.world import parse
from support.ros import scene


@pytest.fixture(scope='module')
def stage(tmp_path_factory):
    """Return a scene with a robot before a wall, and its driver."""
    with scene(tmp_path_factory.mktemp('examples')) as made:
        made.hero = made.robot(world=parse('start 0 0 0\nwall 0.4 -1 0.4 1', 'wall'))
        node = made.node(made.hero.link)
        made.ros.until(lambda: 'robot answers' in node.output, 'the robot answers')
        yield made


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


def test_what_ros2_does_is_done_by_the_example(stage):
    listed = result(stage, 'ros.py', 'list')
    assert '/odom ' in listed and 'create_oi_msgs/srv/SetMode' in listed
    printed(stage, 'create_oi_msgs.msg.Mode', 'ros.py', 'echo', '/mode')
    assert 'success=True' in result(stage, 'ros.py', 'call', '/set_mode', '{mode: 3}')
    assert stage.hero.create.mode is oi.Mode.FULL
    assert 'success=True' in result(stage, 'ros.py', 'call', '/set_mode', '{mode: 2}')
    assert 'successful=True' in result(
        stage, 'ros.py', 'set', '/create', 'cmd_vel_timeout', '0.4')
    program = stage.example('ros.py', 'echo', '/nothing')
    assert program.ended() == 2 and 'nobody publishes /nothing: see list' in program.output


def test_a_node_of_ones_own_turns_away_from_a_wall(stage):
    printed(stage, 'turned by 1.7', 'own_node.py')


def test_leds_blink(stage):
    program = stage.example('leds.py')
    for led in (oi.LedBits.PLAY, oi.LedBits.ADVANCE, oi.LedBits.PLAY):
        stage.ros.until(lambda led=led: stage.hero.create.lights[0] == led, led.name)
    program.send(signal.SIGINT)
    assert program.ended() == 0, program.output


@pytest.mark.nightly
def test_a_long_tune_is_played(stage):
    assert 'the tune was played' in result(stage, 'tune.py')


@pytest.mark.nightly
def test_two_robots_drive_a_square_each(tmp_path):
    with scene(tmp_path) as stage:
        fleet = stage.program('create_fleet', '--simulated', '2')
        stage.ros.until(lambda: fleet.output.count('robot answers') == 2, 'two robots')
        program = stage.example('two_robots.py')
        for count in range(1, 9):
            stage.ros.until(lambda count=count: len(program.printed) >= count, f'move {count}')
        assert program.ended() == 0, program.output
