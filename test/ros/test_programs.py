# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Programs: their start and end, also where ROS hangs, their domain and waiting; the examples."""

import os
from pathlib import Path
import signal
import subprocess
import sys
from types import SimpleNamespace

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import SetMode
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
import pytest
import yaml

from create_oi_ros import oi
from create_oi_ros.apps.run import run_domain
from create_oi_ros.ros import waiting
from create_oi_ros.ros.waiting import (
    announce,
    drivers,
    other_user,
    RunningDriver,
    waits_for,
    WARNING_DELAY,
)
from create_oi_ros.sim.world import parse, Pose, shipped
from support.ros import Ready

HANGS = """
import ctypes
from create_oi_ros.ros import process
{begin}
    node.destroy_node = lambda: ctypes.PyDLL(None).sleep(600)  # Python can do nothing meanwhile
    process.END_TIME = 0.2
    print('done', flush=True)
"""
EXECUTOR = """
import rclpy
with process.ros_executor() as executor:
    node = rclpy.create_node('program')
    executor.add_node(node)
"""
GOALS = """
from create_oi_ros.ros.goal_client import GoalClient
with GoalClient() as robot:
    node = robot.node
"""

SIGNALLED_AGAIN = """
import os, signal, threading
{program}

class Late:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        print('ended', flush=True)
late = Late()  # Python ends it when it has given its signals back
"""
NODE = """
from create_oi_ros.ros.process import call_on_signal
ended = threading.Event()
call_on_signal(ended.set)
os.kill(os.getpid(), signal.SIGINT)
ended.wait()
"""
SIMULATOR = """
from pathlib import Path
from create_oi_ros.sim.server.create_sim import main

def end():
    while not Path('control').exists():
        threading.Event().wait(0.01)
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=end, daemon=True).start()
main(['--link', 'port', '--control', 'control'])
"""


@pytest.mark.parametrize('program', [NODE, SIMULATOR], ids=['a node', 'a simulator'])
def test_a_signal_does_not_kill_what_ends_by_another_one(tmp_path, program: str) -> None:
    done = subprocess.run([sys.executable, '-c', SIGNALLED_AGAIN.format(program=program)],
                          text=True, capture_output=True, timeout=60, check=False, cwd=tmp_path)
    assert done.stdout.endswith('ended\n')
    assert (done.stderr, done.returncode) == ('', 0)


@pytest.mark.parametrize('begin', [EXECUTOR, GOALS], ids=['a node', 'a client of goals'])
def test_a_program_ends_though_ros_hangs_at_its_end_and_tells_where(begin: str) -> None:
    done = subprocess.run([sys.executable, '-c', HANGS.format(begin=begin)], text=True,
                          capture_output=True, timeout=60, check=False)

    assert (done.stdout, done.returncode) == ('done\n', 1)
    assert done.stderr.startswith('Timeout (')
    assert f'in {"ros_executor" if begin == EXECUTOR else "__exit__"}\n' in done.stderr


# The middleware as users have it: over shared memory, where all other tests use UDP.


@pytest.fixture
def default_transport(monkeypatch):
    """Let the middleware choose its transport."""
    monkeypatch.delenv('FASTDDS_BUILTIN_TRANSPORTS')


def test_the_node_drives_answers_and_ends_over_shared_memory(default_transport, stage):
    robot = stage.robot()
    node = stage.node(robot.link)
    odom = stage.ros.listen(Odometry, 'odom')
    stage.ros.drive(0.2, 0.0, lambda: odom and odom[-1].twist.twist.linear.x > 0.1)
    used = Path(f'/proc/{node.pid}/maps').read_text()
    assert '/dev/shm/fastrtps' in used, 'no shared memory is in use'
    assert stage.ros.call(SetMode, 'set_mode', mode=Mode.FULL).success
    node.send(signal.SIGINT)
    assert node.ended() == 0
    stage.ros.until(lambda: robot.standing, 'the last bytes have come')


# A simulated run has a ROS domain and a folder to itself, and leaves nothing behind.


def test_two_runs_have_different_domains_and_one_that_is_set_is_kept(monkeypatch):
    monkeypatch.setattr(os, 'environ', {})
    with run_domain() as first:
        assert os.environ == {
            'ROS_DOMAIN_ID': first, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
        os.environ.clear()
        with run_domain() as second:
            assert second != first
    monkeypatch.setattr(os, 'environ', {'ROS_DOMAIN_ID': '7'})
    with run_domain() as domain:
        assert domain == '7'
    assert os.environ == {'ROS_DOMAIN_ID': '7'}


# A program that waits says for what, in which ROS domain, and where a driver runs.


WAITS = """
import rclpy
from geometry_msgs.msg import Twist
from create_oi_ros.ros.waiting import wait_for_robot
rclpy.init()
node = rclpy.create_node('waits')
velocity = node.create_publisher(Twist, 'cmd_vel', 1)
wait_for_robot(node)
print('found', flush=True)
"""


def node(namespace: str = '/') -> SimpleNamespace:
    """Return what stands for a node in domain 7."""
    return SimpleNamespace(context=SimpleNamespace(get_domain_id=lambda: 7),
                           get_namespace=lambda: namespace)


def test_drivers_of_this_computer_are_known_while_they_run():
    name = f'/robot{os.getpid()}/create'  # others of this computer are known as well
    with announce(221, name), announce(221, name):
        assert drivers().count((221, name, os.getuid())) == 1
    assert name not in {each.name for each in drivers()}
    with announce(221, '/' + 200 * 'long'):
        assert '/long' not in {each.name for each in drivers()}


@pytest.mark.parametrize(('found', 'namespace', 'words'), [
    ([], '/', 'waits for odom in ROS domain 7; on this computer no driver runs: start one with '
              'create_run'),
    ([(215, '/create'), (216, '/r/create')], '/',
     '/create runs in domain 215 (export ROS_DOMAIN_ID=215), /r/create runs in domain 216 '
     '(export ROS_DOMAIN_ID=216, --ros-args -r __ns:=/r)'),
    ([(7, '/robot1/create')], '/',
     '/robot1/create runs in domain 7 (--ros-args -r __ns:=/robot1)'),
    ([(7, '/create')], '/robot1',
     'in ROS domain 7, namespace /robot1; on this computer /create runs in domain 7 '
     '(--ros-args -r __ns:=/)'),
])
def test_it_says_what_it_waits_for_and_where_a_driver_runs(monkeypatch, found, namespace, words):
    monkeypatch.setattr(waiting, 'drivers', lambda: [
        RunningDriver(*each, os.getuid()) for each in found])
    assert waits_for(node(namespace), 'odom', WARNING_DELAY - 0.1) is None
    assert words in waits_for(node(namespace), 'odom', WARNING_DELAY)


@pytest.mark.parametrize(('users', 'transports', 'says'), [
    ([1], None, True), ([1], 'UDPv4', False), ([1, 0], None, False), ([0], None, False)])
def test_a_driver_of_another_user_is_said_to_be_one(monkeypatch, users, transports, says):
    monkeypatch.setattr(waiting, 'drivers', lambda: [
        RunningDriver(7, '/robot1/create', os.getuid() + each) for each in users])
    monkeypatch.delenv(waiting.TRANSPORTS, raising=False)
    if transports:
        monkeypatch.setenv(waiting.TRANSPORTS, transports)
    assert other_user(node('/robot2')) is None, 'the driver of another robot'
    why = other_user(node('/robot1'))
    assert (why is not None) is says
    if why is not None:
        assert 'export FASTDDS_BUILTIN_TRANSPORTS=UDPv4' in why
        assert why in waits_for(node('/robot1'), 'odom', WARNING_DELAY)


def test_a_program_waits_for_a_driver_its_robot_and_that_it_takes_its_commands(stage, tmp_path):
    program = stage.python('-c', WAITS)
    stage.ros.until(lambda: f'in ROS domain {stage.domain}; on this' in program.output)
    stage.listener('recorder').listen(Twist, 'cmd_vel')
    driver = stage.node(tmp_path / 'create', cmd_vel_type='stamped')
    stage.ros.until(lambda: 'waits for a robot (no robot answers)' in program.output)
    stage.robot()
    stage.ros.until(lambda: (
        'waits: the driver takes geometry_msgs/TwistStamped from /cmd_vel, and this program '
        'publishes geometry_msgs/Twist' in program.output), 'why it waits')
    driver.send(signal.SIGTERM)
    driver.ended()
    assert 'found' not in program.output
    stage.node(stage.robot('second').link)
    assert program.ended() == 0
    assert program.printed[-1] == 'found\n'


# Examples with a driver: what ros2 does, a node of your own, LEDs, a tune, two robots, a wall.


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

    def followed() -> bool:
        """Follow the wall; once more where the computer stood still, a gap for the driver."""
        example = stage.example('follow_wall.py')
        stage.ros.until(lambda: not example.running(), 'the cliff')
        assert example.ended() == 0
        why = example.output.partition('the robot has left Safe mode, ')[2]
        assert 'cliff' in why or 'no robot answers' in why, example.output
        return 'cliff' in why
    stage.ros.until(followed)
    robot.soon(lambda: robot.body.place(Pose(0.0, 0.0, 0.0)))
    # The driver waits until the cliff has been gone for more than a second of frames.
    seen = len(odom)
    stage.ros.until(lambda: len(odom) > seen + 100)
    again = stage.example('follow_wall.py')
    stage.ros.until(lambda: odom[-1].twist.twist.linear.x > 0.1)
    assert again.running()
