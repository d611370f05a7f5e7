# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a user gets wrong is one sentence and exit code 2; a bug keeps its traceback."""

from contextlib import nullcontext
from dataclasses import fields, replace
import errno
import os
import re
import signal
import subprocess
import sys
from types import SimpleNamespace

from create_oi_msgs.msg import Mode
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from create_oi_ros import __version__
from create_oi_ros.ros import node_arguments, programs
from create_oi_ros.ros.parameters import contradiction, Parameters, refusal, wrong_type
from create_oi_ros.ros.programs import check_environment, explained, MODULES, PROGRAMS, UserError
from support.ros import Ready

ROS_PROGRAMS = {
    'create_node': [], 'create_run': ['--world', 'empty'], 'create_record': ['-o', 'new']}


def run(program: str, *arguments: str, cwd=None, **environment: str | None):
    """Run a program to its end; None removes a variable."""
    changed = {**os.environ, 'ROS_DOMAIN_ID': '1', **environment}
    return subprocess.run(
        [sys.executable, '-c', PROGRAMS[program], *arguments], text=True, capture_output=True,
        timeout=60, cwd=cwd, env={name: value for name, value in changed.items()
                                  if value is not None})


def one_sentence(done, program: str) -> str:
    """Check that a program refused something in one line; return the line."""
    assert done.returncode == 2, done.stderr
    # ROS itself may warn before.
    line, = (each for each in done.stderr.splitlines() if '] [rcl]: ' not in each)
    assert line.startswith(f'{program}: ')
    return line


@pytest.mark.parametrize('program', MODULES)
def test_every_program_tells_its_version(program):
    done = run(program, '--version')
    assert (done.returncode, done.stdout, done.stderr) == (0, f'{program} {__version__}\n', '')


@pytest.mark.parametrize('program', ROS_PROGRAMS)
def test_a_wrong_domain_is_one_sentence_and_nothing_starts(program, tmp_path):
    done = run(program, *ROS_PROGRAMS[program], cwd=tmp_path, ROS_DOMAIN_ID='abc')
    assert "ROS_DOMAIN_ID is 'abc': allowed is a whole number from 0 to 232" in one_sentence(
        done, program)
    assert done.stdout == ''
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(('environment', 'words'), [
    ({'HOME': None, 'ROS_HOME': None, 'ROS_LOG_DIR': None}, 'set HOME, or ROS_LOG_DIR'),
    ({'ROS_LOG_DIR': '/proc/logs'}, 'set HOME, or ROS_LOG_DIR'),
    ({'ROS_LOG_DIR': __file__}, 'set HOME, or ROS_LOG_DIR'),
    ({'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Enforce',
      'ROS_SECURITY_KEYSTORE': None}, 'set ROS_SECURITY_KEYSTORE'),
    *(({'ROS_DOMAIN_ID': domain}, 'from 0 to 232') for domain in ('233', '-1', '1.5', ' ', '²')),
    *(({'ROS_DOMAIN_ID': domain}, None) for domain in ('', '0', '232'))])
def test_an_environment_in_which_ros_cannot_start_is_refused_with_what_to_set(
        environment, words, monkeypatch):
    for name, value in environment.items():
        if value is None:
            monkeypatch.delenv(name, raising=False)
        else:
            monkeypatch.setenv(name, value)
    with pytest.raises(UserError, match=words) if words else nullcontext():
        check_environment()


@pytest.mark.parametrize(('arguments', 'words'), [
    (['-p', 'port:='], 'write -p NAME:=VALUE; an empty text is'),
    (['-p', 'port'], 'write -p NAME:=VALUE'),
    (['-p', 'port:=[1,a'], '-p port:=[1,a cannot be read'),
    (['--param', 'port:='], 'write -p NAME:=VALUE'),
    (['-r', '__ns:='], "a namespace begins with '/'"),
    (['-r', '__ns:=robot'], "a namespace begins with '/'"),
    (['--remap', '__node:='], 'write -r FROM:=TO'),
    (['--log-level', 'loud'], 'allowed: debug, info, warn, error, fatal'),
    (['--params-file', '/nowhere.yaml'], '--params-file /nowhere.yaml: there is no such file'),
    (['--params-file', '/'], 'there is no such file'),
    (['--bogus'], "unknown among the ROS arguments: ['--bogus']"),
])
def test_ros_arguments(arguments, words):
    assert words in refused_by_ros(*arguments)


def refused_by_ros(*arguments: str) -> str:
    """Have ROS refuse arguments; return the sentence about that."""
    with pytest.raises(RuntimeError) as refused:
        node_arguments.parse(['--ros-args', *arguments])
    return explained(refused.value) or ''


@pytest.mark.parametrize('content', [
    b'create: [b', b'create:\n  ros__parameters:\n    port: [1, a]\n', b'\xff\xfe\x00'])
def test_a_parameter_file_that_cannot_be_read(content, tmp_path):
    (tmp_path / 'bad.yaml').write_bytes(content)
    sentence = refused_by_ros('--params-file', str(tmp_path / 'bad.yaml'))
    assert 'bad.yaml cannot be read (' in sentence


@pytest.mark.parametrize(('error', 'sentence'), [
    (PermissionError(errno.EACCES, os.strerror(errno.EACCES), '/root/demo'),
     '/root/demo: you may not write or read here: give a place of your own'),
    (NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), 'file/demo'),
     'file/demo: a part of this path is a file: give a folder'),
    (OSError(errno.ENOSPC, 'No space left on device'),
     'No space left on device: nothing more can be written'),
    (type('RCLError', (RuntimeError,), {})(
        'failed to initialize rcl: no enclave, at /project/src/rcl/security.c:1'),
     'ROS does not start: failed to initialize rcl: no enclave'),
    *((bug, None) for bug in (
        RuntimeError('a bug'), OSError(errno.EBADF, 'Bad file descriptor'),
        OSError(errno.ENOENT, 'no name is given'),
        ModuleNotFoundError(name='create_oi_ros.other')))])
def test_an_error_is_a_sentence_and_a_bug_is_not_explained(error, sentence):
    assert explained(error) == sentence


def test_a_reader_that_ends_early_is_no_error(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer) as output:
        done = subprocess.run(
            [sys.executable, '-c', PROGRAMS['create_sim'], '--export', 'room.yaml'], text=True,
            stdout=output, stderr=subprocess.PIPE, timeout=60, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (128 + signal.SIGPIPE, '')


SYSTEM, VENV = '/usr', '/home/me/venv'
COLCON = 'create_oi_msgs is missing: it is the package msg_defs of this repository: `colcon build '
CLONE = '`make` in a clone of this repository, then `source env.sh` there'


@pytest.mark.parametrize(('module', 'prefix', 'ros', 'sentence'), [
    ('rclpy', SYSTEM, 'jazzy, not sourced', 'ROS 2 Jazzy is missing: `source '),
    ('rclpy', SYSTEM, 'none', f'ROS 2 Jazzy is missing: {CLONE}\n'),
    ('geometry_msgs.msg', VENV, 'none', f'ROS 2 Jazzy is missing: {CLONE}\n'),
    ('create_oi_msgs.msg', VENV, 'none', f'ROS 2 Jazzy is missing: {CLONE}\n'),
    ('create_oi_msgs.msg', SYSTEM, 'jazzy', COLCON),
    ('create_oi_msgs.msg', VENV, 'wheels', f'create_oi_msgs is missing: {CLONE}\n'),
    ('nav_msgs.msg', SYSTEM, 'jazzy', 'nav_msgs is missing: it is a part of ROS 2 Jazzy'),
    ('serial', SYSTEM, 'none', 'serial is missing: `sudo apt-get install python3-serial`\n'),
    ('serial', VENV, 'none', "serial is missing: `'/home/me/my venv/python' -m pip install "
                             'pyserial`\n'),
    ('aiohttp', SYSTEM, 'none', 'aiohttp is missing: `sudo apt-get install python3-aiohttp`\n'),
    ('numpy', VENV, 'jazzy', "numpy is missing: `'/home/me/my venv/python' -m pip install ")])
def test_a_missing_part_is_one_sentence_that_fits_this_python(
        module, prefix, ros, sentence, monkeypatch, capsys, tmp_path):
    jazzy = tmp_path / 'setup.bash'
    if ros.startswith('jazzy'):
        jazzy.touch()
    monkeypatch.setattr(programs, 'JAZZY', jazzy)
    monkeypatch.setattr(programs, 'find_spec', lambda name: {
        'jazzy': SimpleNamespace(origin='/opt/ros/jazzy/lib/python3.12/rclpy'),
        'wheels': SimpleNamespace(origin=f'{VENV}/lib/python3.12/rclpy')}.get(ros))
    monkeypatch.delenv('CREATE_OI_ENV', raising=False)
    monkeypatch.setattr(sys, 'prefix', prefix)
    monkeypatch.setattr(sys, 'base_prefix', SYSTEM)
    monkeypatch.setattr(sys, 'executable', '/home/me/my venv/python')

    def fail(name):
        raise ModuleNotFoundError(name=module)
    monkeypatch.setattr(programs, 'import_module', fail)
    monkeypatch.setattr(sys, 'argv', ['create_node'])
    monkeypatch.setattr(signal, 'signal', lambda number, handler: None)
    assert programs.create_node() == 2
    assert capsys.readouterr().err.startswith(f'create_node: {sentence}')


@pytest.mark.parametrize(('program', 'name', 'found', 'words'), [
    ('create_record', 'rosbags', '0.10.4', 'rosbags 0.10.4 does not fit: `'),
    ('create_report', 'rosbags', '0.12', 'rosbags 0.12 does not fit: `'),
    ('create_report', 'mcap', '1.4.9', 'mcap 1.4.9 does not fit: `'),
    ('create_record', 'mcap', '2.0.0a1', 'mcap 2.0.0a1 does not fit: `'),
])
def test_another_version_of_a_library_is_refused_before_anything_is_written(
        program, name, found, words, tmp_path):
    metadata = tmp_path / 'site' / f'{name}-{found}.dist-info' / 'METADATA'
    metadata.parent.mkdir(parents=True)
    metadata.write_text(f'Metadata-Version: 2.1\nName: {name}\nVersion: {found}\n')
    here = tmp_path / 'here'
    here.mkdir()
    path = os.pathsep.join(filter(None, (
        str(tmp_path / 'site'), os.environ.get('PYTHONPATH'))))
    said = one_sentence(run(program, 'walk', cwd=here, PYTHONPATH=path), program)
    assert words in said and f"'{name}>=" in said and 'pip install' in said
    assert not list(here.iterdir())


# What a user may mistype when starting `create_node`.


@pytest.mark.parametrize(('arguments', 'words'), [
    (['--port', '/dev/ttyUSB3'], '--port is a parameter: write --ros-args -p port:=/dev/ttyUSB3'),
    (['--cmd-vel-timeout=1.0'], 'write --ros-args -p cmd_vel_timeout:=1.0'),
    (['--bogus'], 'unknown argument --bogus'),
    (['--versoin'], 'did you mean --version?'),
    (['/dev/ttyUSB0'], 'unknown argument /dev/ttyUSB0'),
    (['port:=/dev/x'], 'write --ros-args -p port:=/dev/x'),
    (['-p', 'port:=/dev/x'], '-p is for ROS: write --ros-args -p port:=/dev/x'),
    (['--ros-args', '-p', 'baud:=0', '--', '--help-me'], 'unknown argument --help-me'),
])
def test_an_unknown_argument_is_refused_with_what_may_be_meant(capsys, arguments, words):
    with pytest.raises(SystemExit) as ended:
        node_arguments.parse(arguments)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_help_names_every_parameter_with_its_default(capsys):
    with pytest.raises(SystemExit) as ended:
        node_arguments.parse(['--help'])
    shown = capsys.readouterr().out
    assert not ended.value.code
    assert 'cmd_vel_timeout:=0.5' in shown
    for declared in fields(Parameters):
        assert f'\n  {declared.name}:=' in shown


@pytest.mark.parametrize(('changes', 'words'), [
    ({'odom_frame': 'base', 'base_frame': 'base'}, 'a frame cannot move in itself'),
    ({'battery_low': 12.0, 'battery_empty': 13.0}, 'low before it is empty'),
    ({'gyro': 'analog', 'baud': 19200}, '19200 baud carries 28 bytes in a slot'),
    ({'gyro': 'analog', 'gyro_scale': 0.0}, "give the data sheet's degrees a second"),
])
def test_values_that_contradict_each_other_are_refused(changes, words):
    assert words in contradiction(replace(Parameters(), **changes))
    assert contradiction(Parameters()) is None


def test_the_place_of_a_dock_is_three_numbers():
    for wrong in ('1 2', '1 2 3 4', 'a b c', '1 2 nan'):
        assert "allowed: x, y (m) and yaw (rad) as '1.0 2.0 3.14'" in refusal('dock_pose', wrong)
    assert refusal('dock_pose', '') is refusal('dock_pose', '1, -2.0 0.5') is None
    assert replace(Parameters(), dock_pose='1, -2.0 0.5').settings().dock_pose == (1.0, -2.0, 0.5)
    assert Parameters().settings().dock_pose is None


@pytest.mark.parametrize(('names', 'words'), [
    (('lamp', 'door', 'lamp'), "has 'lamp' twice: give each a name of its own"),
    (('lamp', '', 'c'), 'has an empty name: write output_1'),
    (('a', 'b', 'c', 'd', 'e'), 'has 5 names; allowed: up to 3'),
])
def test_names_that_cannot_be_told_apart_and_frames_with_a_slash_are_refused(names, words):
    assert f'parameter output_names {words}' in refusal('output_names', names)
    assert "write 'odom'" in refusal('odom_frame', '/odom')
    assert refusal('odom_frame', 'robot_1/odom') is None


@pytest.mark.parametrize(('name', 'value', 'words'), [
    ('baud', 'fast', "= 'fast' is of the wrong type: it takes a whole number; write 57600, for"),
    ('publish_tf', 'yes', 'it takes true or false; write true, for example'),
    ('cmd_vel_timeout', True, 'it takes a number; write 0.5'),
    ('bump_stop', False, 'it takes text; allowed: none, forward'),
    ('port', 3, """write '3' with its quotes (after -p: port:="'3'")"""),
    ('mode_on_start', True, 'allowed: passive, safe, full'),
    ('output_names', 'lamp', 'takes a list of names; write [output_0, output_1, output_2]'),
    ('dock_pose', [1.0, 2.0, 0.5], "write '1.0 2.0 0.5' with its quotes"),
])
def test_a_value_of_the_wrong_type_says_how_to_write_it(name, value, words):
    assert words in wrong_type(name, value)


# QoS overrides, named as rclcpp and rclpy name them.


OVERRIDES = """
/robot1/create:
  ros__parameters:
    qos_overrides:
      /robot1/odom:
        publisher: {reliability: best_effort, depth: 2}
      /robot1/lines:
        publisher: {reliability: best_effort, history: keep_all}
      /tf: {publisher: {depth: 7}}
      /robot1/odom_lines: {publisher: {depth: 7}}
      /robot1/buttons: {publisher: {reliability: best_effort, depth: 3}}
      /robot1/mode: {publisher: {durability: volatile}}
      /robot1/cmd_vel: {subscription: {reliability: best_effort}}
"""
"""For a robot in a namespace, whose topic `bumper` is remapped to `lines`."""


def test_qos_overrides_are_followed_or_named_and_ignored(stage, tmp_path):
    (tmp_path / 'qos.yaml').write_text(OVERRIDES)
    robot = stage.robot()
    node = stage.program(
        'create_node', '--ros-args', '-r', '__ns:=/robot1', '-r', 'bumper:=lines', '-p',
        f'port:={robot.link}', '--params-file', str(tmp_path / 'qos.yaml'))
    offered = stage.ros.node.get_publishers_info_by_topic
    names = 'odom', 'lines', 'cliff', 'buttons', 'mode'
    stage.ros.until(lambda: all(offered(f'/robot1/{name}') for name in names))
    found = {name: offered(f'/robot1/{name}')[0].qos_profile for name in names}
    assert {name: qos.reliability.name for name, qos in found.items()} == {
        'odom': 'BEST_EFFORT', 'lines': 'BEST_EFFORT', 'cliff': 'RELIABLE',
        'buttons': 'RELIABLE', 'mode': 'RELIABLE'}
    assert found['buttons'].durability is found['mode'].durability is (
        DurabilityPolicy.TRANSIENT_LOCAL)
    heard = stage.ros.listen(Odometry, '/robot1/odom', QoSProfile(
        depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
    stage.ros.until(lambda: heard, 'odometry')
    ignored = re.findall(r'parameter (qos_overrides\S+) cannot be overridden', node.output)
    assert sorted(ignored) == [
        'qos_overrides./robot1/buttons.publisher.reliability',
        'qos_overrides./robot1/cmd_vel.subscription.reliability',
        'qos_overrides./robot1/mode.publisher.durability',
        'qos_overrides./robot1/odom_lines.publisher.depth']
    assert stage.ros.parameters('/robot1/create', *(
        f'qos_overrides.{topic}.publisher.depth'
        for topic in ('/robot1/odom', '/tf', '/robot1/cliff'))) == [2, 7, 10]


QOS = 'qos_overrides./odom.publisher'


@pytest.mark.parametrize(('given', 'words'), [
    (f'{QOS}.reliability:=often',
     f"parameter {QOS}.reliability = 'often'; allowed: reliable, best_effort"),
    (f'{QOS}.history:=all', f"parameter {QOS}.history = 'all'; allowed: keep_last, keep_all"),
    (f'{QOS}.depth:=0', f'parameter {QOS}.depth = 0; allowed: 1 to 2147483647'),
    ('output_names:=[]',
     'a parameter is an empty list, [], of which ROS cannot tell the type: leave it out'),
])
def test_a_wrong_parameter_ends_the_node_with_what_is_allowed(stage, given, words):
    node = stage.program('create_node', '--ros-args', '-p', given)
    assert node.ended() == 2
    assert f'create_node: {words}' in node.output


# Mistakes in the ROS graph are reported: types, namespaces, two drivers, frames.


def test_commands_of_a_wrong_type_and_in_another_namespace_are_named_once(stage):
    node = stage.node(stage.robot().link, '__ns:=/robot1', cmd_vel_type='twist')
    stage.ros.node.create_publisher(TwistStamped, '/robot1/cmd_vel', 1)
    stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    warnings = (
        '/listener publishes /robot1/cmd_vel as geometry_msgs/TwistStamped, but this driver takes '
        'geometry_msgs/Twist: its commands are ignored',
        '/listener publishes /cmd_vel, to which nobody listens; this driver listens to '
        '/robot1/cmd_vel')
    stage.ros.until(lambda: all(warning in node.output for warning in warnings))
    beats = stage.ros.listen(DiagnosticArray, '/diagnostics')
    stage.ros.until(lambda: len(beats) > 2)
    assert [node.output.count(warning) for warning in warnings] == [1, 1]
    assert 'cmd_vel_type: auto' in node.output


def test_stamped_commands_drive_when_alone_and_beside_others_are_named(stage):
    ready = Ready(stage)
    stamped = stage.listener('nav2').node.create_publisher(TwistStamped, 'cmd_vel', 1)
    command = TwistStamped(twist=Twist(linear=Vector3(x=0.1)))
    timer = stage.ros.node.create_timer(0.1, lambda: stamped.publish(command))
    stage.ros.until(lambda: ready.robot.body.truth().speed > 0.05)
    assert '/nav2 publishes' not in ready.node.output
    stage.listener('wheel').node.create_publisher(Twist, 'cmd_vel', 1)
    stage.ros.until(
        lambda: '/wheel publishes /cmd_vel as geometry_msgs/Twist, but' in ready.node.output)
    assert 'Let all publishers send the same type' in ready.node.output
    timer.cancel()
    stage.ros.until(lambda: ready.robot.body.truth().speed <= 0.05, 'the command timeout')


def test_two_robots_with_the_same_frames_are_reported(stage):
    nodes = [stage.node(stage.robot(name).link, f'__ns:=/{name}') for name in ('one', 'two')]
    third = stage.node(
        stage.robot('three').link, '__ns:=/three', odom_frame='three/odom',
        base_frame='three/base_footprint')
    for node, other in zip(nodes, ('two', 'one')):
        stage.ros.until(lambda node=node, other=other: (
            f'/{other}/create publishes a transform to base_footprint on /tf' in node.output))
    assert 'odom_frame: one/odom' in nodes[0].output
    stage.ros.until(lambda: 'robot answers' in third.output)
    assert '/three/create publishes' not in ''.join(node.output for node in nodes)
    assert 'publishes a transform' not in third.output


def test_two_drivers_of_one_name_are_reported_and_after_the_second_the_first_has_its_say(stage):
    ready = Ready(stage)
    second = stage.node(stage.folder / 'nowhere')
    for node in (ready.node, second):
        stage.ros.until(lambda node=node: 'another node is called /create' in node.output)
    ready.until_mode(Mode.UNKNOWN)  # the second has no robot
    second.send(signal.SIGTERM)
    assert second.ended() == 0
    ready.until_mode(Mode.SAFE)  # the first has one
