# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a user may mistype when starting `create_node`, and what is said then."""

from dataclasses import fields, replace

import pytest
import yaml

from create_oi_ros import __version__
from create_oi_ros.ros import node_arguments
from create_oi_ros.ros.node import NAMES
from create_oi_ros.ros.node_arguments import unused_files, unused_remaps
from create_oi_ros.ros.parameters import contradiction, Parameters, refusal, wrong_type


@pytest.mark.parametrize(('arguments', 'words'), [
    (['--port', '/dev/ttyUSB3'], '--port is a parameter: write --ros-args -p port:=/dev/ttyUSB3'),
    (['--cmd-vel-timeout=1.0'], 'write --ros-args -p cmd_vel_timeout:=1.0'),
    (['--bogus'], 'unknown argument --bogus'),
    (['--versoin'], 'did you mean version?'),
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


def test_version_is_told(capsys):
    with pytest.raises(SystemExit):
        node_arguments.parse(['--version'])
    assert capsys.readouterr().out == f'create_node {__version__}\n'


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
    (('lamp', 'door', 'lamp', 'd'), "has 'lamp' twice: give each a name of its own"),
    (('lamp', '', 'c', 'd'), 'has an empty name: write input_1'),
    (('a', 'b', 'c', 'd', 'e'), 'has 5 names; allowed: up to 4'),
])
def test_names_that_cannot_be_told_apart_and_frames_with_a_slash_are_refused(names, words):
    assert f'parameter input_names {words}' in refusal('input_names', names)
    assert "write 'odom'" in refusal('odom_frame', '/odom')
    assert refusal('odom_frame', 'robot_1/odom') is None


@pytest.mark.parametrize(('name', 'value', 'words'), [
    ('baud', 'fast', "= 'fast' is of the wrong type: it takes a whole number; write 57600, for"),
    ('baud', 57600.0, 'write 57600'), ('baud', '57600', 'write 57600'),
    ('publish_tf', 'yes', 'it takes true or false; write true, for example'),
    ('publish_tf', 'true', 'write true'), ('publish_tf', 0, 'write true'),
    ('cmd_vel_timeout', '0.5', 'write 0.5'),
    ('cmd_vel_timeout', True, 'it takes a number; write 0.5'),
    ('bump_stop', False, 'it takes text; allowed: none, forward'),
    ('port', 3, """write '3' with its quotes (after -p: port:="'3'")"""),
    ('mode_on_start', True, 'allowed: passive, safe, full'),
    ('input_names', 'lamp', 'takes a list of names; write [input_0, input_1, input_2, input_3]'),
    ('dock_pose', [1.0, 2.0, 0.5], "write '1.0 2.0 0.5' with its quotes"),
])
def test_a_value_of_the_wrong_type_says_how_to_write_it(name, value, words):
    assert words in wrong_type(name, value)


def test_no_choice_is_what_yaml_reads_as_a_boolean_or_as_nothing():
    for field in fields(Parameters):
        for choice in field.metadata['choices']:
            assert type(yaml.safe_load(str(choice))) is type(field.default), field.name


def test_what_is_wrong_at_start_is_one_line_and_exit_code_2(stage):
    node = stage.node(stage.folder / 'none', cmd_vel_timeout=20)
    assert node.ended() == 2
    assert node.output.strip().endswith(
        'create_node: parameter cmd_vel_timeout = 20; allowed: 0.05 to 10')


ROBOT = ('/robot1', 'create')


@pytest.mark.parametrize(('rule', 'node', 'words'), [
    ('cmdvel:=x', ('/', 'create'), 'here is called cmdvel: did you mean cmd_vel?'),
    ('set_led:=x', ('/', 'create'), 'did you mean set_leds?'),
    ('/cmd_vel:=/x', ROBOT, 'did you mean cmd_vel?'), ('__nss:=/x', ROBOT, 'did you mean __ns?'),
    ('zzz:=x', ROBOT, 'no topic or service here is called zzz'),
    ('rotate_angle:=x', ROBOT, 'did you mean rotate_angle/_action/status?'),
    ('rotate_angel/_action/status:=x', ROBOT, 'did you mean rotate_angle/_action/status?'),
    ('driver:cmd_vel:=x', ROBOT, 'it is for a node driver, this one is create'),
    ('rostopic://odometry:=x', ROBOT, 'no topic or service here is called odometry'),
    *((rule, ROBOT, None) for rule in (
        'cmd_vel:=x', '/robot1/cmd_vel:=x', 'create:cmd_vel:=x', '/tf:=tf', '/tf_static:=tf',
        '__ns:=/robot1', 'create:__node:=x', '~/set_parameters:=x', 'rosservice://stop:=x',
        '/diagnostics:=diagnostics', 'dock/_action/send_goal:=x'))])
def test_a_remap_without_effect_is_told_with_the_nearest_name(rule, node, words):
    said = unused_remaps(['create_node', '--ros-args', '-r', rule], [node], NAMES)
    assert len(said) == (words is not None)
    if words is not None:
        assert said[0].startswith(f'remap {rule} has no effect: ') and words in said[0]


@pytest.mark.parametrize(('content', 'used'), [
    ('', False), ('hello\n', False), ('other:\n  ros__parameters: {baud: 19200}\n', False),
    ('create:\n  ros__parameters: {baud: 19200}\n', False),
    ('/robot1/create:\n  ros__parameters: {baud: 19200}\n', True),
    ('robot1:\n  create:\n    ros__parameters: {baud: 19200}\n', True),
    ('/*/create:\n  ros__parameters: {baud: 19200}\n', True),
    ('/*/*/create:\n  ros__parameters: {baud: 19200}\n', False),
    ('/**/create:\n  ros__parameters: {baud: 19200}\n', True),
    ('/**:\n  ros__parameters: {baud: 19200}\n', True)])
def test_a_parameter_file_for_another_node_is_told(tmp_path, content, used):
    (tmp_path / 'my.yaml').write_text(content)
    said = list(unused_files(['--ros-args', '--params-file', str(tmp_path / 'my.yaml')],
                             '/robot1/create'))
    assert not said if used else 'holds no parameter of this node, /robot1/create, but' in said[0]


def test_what_has_no_effect_is_a_warning_and_what_is_not_supported_is_refused(stage, tmp_path):
    """Each of these starts the program."""
    (tmp_path / 'other.yaml').write_text('other:\n  ros__parameters: {baud: 19200}\n')
    warned = stage.program(
        'create_node', '--ros-args', '-p', 'cmd_vel_timout:=1.0', '-r', 'cmdvel:=x',
        '-r', 'odom:=x', '--params-file', str(tmp_path / 'other.yaml'))
    refused = stage.node(
        stage.folder / 'none', **{'qos_overrides./odom.publisher.reliability': 'best_effort'})
    assert refused.ended() == 2
    assert 'qos_overrides./odom.publisher.reliability is not supported' in refused.output
    for words in ('cmd_vel_timout is unknown and ignored: did you mean cmd_vel_timeout?',
                  'did you mean cmd_vel?', 'holds no parameter of this node, /create, but'):
        stage.ros.until(lambda words=words: words in warned.output, words)
    assert 'remap odom' not in warned.output
