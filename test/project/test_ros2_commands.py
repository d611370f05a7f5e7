# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The documented `ros2` commands, typed as they stand in the pages, with the real tools.

Only the port is another one, of a simulated robot. `ros2 launch` is in test/ros/test_launch.py.
"""

from create_oi_msgs.srv import DefineSong
import pytest

from support.ros2 import Ros2
from support.source import ROOT, ros2_commands

PACKAGE = 'create_oi_ros'
LEFT_OUT = {
    'diagnostic_aggregator', 'foxglove_bridge', 'joy', 'nav2_bringup', 'nav2_map_server',
    'robot_localization', 'ros2bag', 'rqt_robot_monitor', 'slam_toolbox', 'sros2',
    'teleop_twist_joy', 'teleop_twist_keyboard', 'tf2_ros'}
"""Packages that are not here; commands that need one are not run."""
VERBS = {'bag': 'ros2bag', 'security': 'sros2'}
"""Words after `ros2` that another package brings."""
SHOWS = {
    'action list': '/drive_distance', 'action send_goal': 'status: SUCCEEDED',
    'daemon stop': 'daemon', 'interface show': '# ', 'node list': '/create\n',
    'param describe': 'seconds after the last', 'param list': 'cmd_vel_timeout',
    'param set': 'Set parameter successful', 'run create_node': 'robot answers',
    'run create_web': 'open http://', 'service call': 'success=True', 'service list': '/set_mode',
    'topic echo': '\n---\n', 'topic hz': 'average rate: ',
    'topic info': 'Node name: create_cmd_vel', 'topic list': '/odom', 'topic pub': 'publishing #3'}
"""Part of what each kind of command prints when it works."""
LASTING = {'run create_node', 'run create_web', 'topic echo', 'topic hz', 'topic pub'}
"""Those that run until Ctrl-C; others are repeated while the graph or the robot is not known."""


def kind(words):
    """Return the kind of a command: a key of SHOWS."""
    return f'run {words[3]}' if words[1] == 'run' else ' '.join(words[1:3])


def needs(words):
    """Return the package that a command needs."""
    return words[2] if words[1] in ('run', 'launch') else VERBS.get(words[1], PACKAGE)


DRIVER = ('ros2', 'run', PACKAGE, 'create_node', '--ros-args', '--params-file', 'my_create.yaml')
"""Starts the driver that the other commands ask."""
OURS = [words for words in ros2_commands()
        if needs(words) == PACKAGE and words[1] != 'launch' and words != DRIVER]
# The daemon is ended last; before it, what was learned is saved: the robot must have driven.
OURS.sort(key=lambda words: (words[1] == 'daemon', '/save_odometry_model' in words))


@pytest.fixture(scope='module')
def typed(ros2: Ros2):
    """Return a function that types a command, and waits until it has worked."""
    robot = ros2.stage.robot()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ros2.stage.folder)
        text = (ROOT / 'config' / 'create.yaml').read_text('utf-8')
        (ros2.stage.folder / 'my_create.yaml').write_text(text.replace(
            '/dev/ttyUSB0', str(robot.link)).replace('odometry_model: ""', 'odometry_model: "m"'))

        def run(words):
            given = [word.replace('PORT', str(robot.link)) for word in words[1:]]
            if kind(words) not in LASTING:
                ros2.run(*given, shows=lambda output: SHOWS[kind(words)] in output)
                return
            program = ros2.start(*given, terminal=True)
            ros2.stage.ros.until(
                lambda: SHOWS[kind(words)] in program.output.replace('\r', ''), ' '.join(words))
            program.type('\x03')
            program.ended()
        yield run


def test_each_command_is_run_or_its_package_is_listed():
    assert {needs(words) for words in ros2_commands()} == LEFT_OUT | {PACKAGE}
    assert DRIVER in ros2_commands()


@pytest.mark.parametrize('words', [words for words in OURS if words[1] == 'run'], ids=' '.join)
def test_a_program_is_started(typed, words):
    typed(words)


@pytest.fixture(scope='module')
def driver(ros2, typed):
    """Start a driver that the following commands ask, and have a song in the robot."""
    program = ros2.start(*DRIVER[1:])
    ros2.stage.ros.until(lambda: 'entering SAFE' in program.output)
    ros2.stage.ros.until(lambda: ros2.stage.ros.call(
        DefineSong, 'define_song', pitches=[60], seconds=[0.1]).success, 'the song is stored')


@pytest.mark.parametrize('words', [words for words in OURS if words[1] != 'run'], ids=' '.join)
def test_a_command_asks_or_moves_a_running_driver(driver, typed, words):
    typed(words)
