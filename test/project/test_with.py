# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Files beside the code, and those for other packages, describe this robot correctly.

Frames, speeds and sizes are compared with the driver's parameters and the model; topics and fields
with what the driver publishes. The other packages need not be installed.
"""

from collections.abc import Iterator
from configparser import ConfigParser
from functools import cache
import json
from math import hypot
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
from typing import Any
from xml.etree import ElementTree

from geometry_msgs.msg import Twist
import pytest
import rclpy
from rclpy.context import Context
import yaml

from create_oi_ros.driver.contacts import LEFT_BEHIND, OUTSIDE
from create_oi_ros.odometry import Geometry
from create_oi_ros.robot import BODY_RADIUS
from create_oi_ros.ros import diagnostics
from create_oi_ros.ros.messages import HEIGHT, WHEEL_JOINTS
from create_oi_ros.ros.parameters import Parameters
from create_oi_ros.ros.topics import ALL_TOPICS, CONTACTS, PUBLISHED
from document import config
from support.source import ROOT, ros2_commands

FILES = ROOT / 'config' / 'with'
URDF = ROOT / 'urdf' / 'create.urdf'
MODEL = ElementTree.parse(URDF).getroot()
PADDING = 0.01
"""Metres in x and y that Nav2 adds to a footprint, unless it is told otherwise."""
COSTMAPS = ('local_costmap', 'global_costmap')
OURS = {f'/{topic.name.lstrip("/")}' for topic in ALL_TOPICS} | {'/cmd_vel'}
"""Full names of all topics of a driver without a namespace."""
FOREIGN = {'/scan', '/imu/data', '/cmd_vel_smoothed', '/joy', '/diagnostics_toplevel_state',
           '/robot_description'}
"""Other nodes' topics that files and pages may name: lidar, IMU, Nav2, joy, aggregator, model."""
TYPES = {topic.name.lstrip('/'): topic.type for topic in PUBLISHED} | {'cmd_vel': Twist}


@cache
def nodes(file: str) -> dict[str, dict[str, Any]]:
    """Return the parameters of each node that a file is for, which ROS's own parser accepts."""
    context = Context()
    rclpy.init(args=['--ros-args', '--params-file', str(FILES / file)], context=context)
    rclpy.shutdown(context=context)
    found = yaml.safe_load((FILES / file).read_text('utf-8'))
    return {name: dict(flat(below.get(name, below)['ros__parameters']))
            for name, below in found.items()}  # a costmap is within a namespace of its name


def flat(tree: dict[str, Any], prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield parameters by their full names."""
    for name, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f'{prefix}{name}.')
        else:
            yield prefix + name, value


def nav2(node: str) -> dict[str, Any]:
    """Return the parameters of one of Nav2's nodes."""
    return nodes('nav2.yaml')[node]


def test_frames_and_topics_of_the_files_exist():
    for path in FILES.glob('*.yaml'):
        for found in nodes(path.name).values():
            for name, value in found.items():
                if re.search('frame(_id)?$', name):
                    assert value == frame(name.rpartition('.')[2], found), name
                if re.search(r'(^|[_.])topic$|^(odom|imu)\d$', name):
                    assert f'/{value.lstrip("/")}' in OURS | FOREIGN, name


def frame(name: str, others: dict[str, Any]) -> str:
    """Return the value that a parameter for a frame must have."""
    if name.startswith(('base', 'robot_base')):
        return Parameters.base_frame
    if name.startswith(('odom', 'local', 'fixed', 'world')):
        return Parameters.odom_frame
    assert name.startswith(('map', 'global', 'route'))
    return Parameters.odom_frame if others.get('rolling_window') else 'map'


def test_the_robot_is_as_wide_as_its_model():
    body, = MODEL.findall("./link[@name='base_link']/collision/geometry/cylinder")
    radius = float(body.get('radius'))
    for costmap in COSTMAPS:
        assert nav2(costmap)['robot_radius'] == radius
        assert nav2(costmap)['inflation_layer.inflation_radius'] > radius
    assert nav2('collision_monitor')['body.radius'] == radius


@pytest.mark.parametrize('costmap', COSTMAPS)
def test_both_costmaps_see_as_far_as_the_lidar_feel_the_bumper_and_keep_what_it_felt(costmap):
    found = nav2(costmap)
    for layer in (name.removesuffix('.observation_sources') for name in found
                  if name.endswith('.observation_sources')):
        # Nav2's own default is 0: no lidar is as low as that.
        source = found[f'{layer}.observation_sources']
        assert found[f'{layer}.{source}.max_obstacle_height'] > HEIGHT
        if source == 'scan':
            scan = f'{layer}.scan'
            assert found[f'{scan}.topic'] == '/scan'
            assert found[f'{scan}.obstacle_max_range'] <= found[f'{scan}.raytrace_max_range'] <= 8
    assert any(name.endswith('.scan.topic') for name in found)
    layer = {name.removeprefix('contact_layer.'): value for name, value in found.items()
             if name.startswith('contact_layer.')}
    assert layer['observation_sources'] == 'contacts'
    assert layer['contacts.topic'] == f'/{CONTACTS.name}'
    assert layer['contacts.data_type'] == CONTACTS.type.__name__
    assert layer['contacts.marking'] and not layer['contacts.clearing']
    assert layer['contacts.min_obstacle_height'] < HEIGHT < layer['contacts.max_obstacle_height']
    # Nav2 clears each cell that the footprint touches, also half of one.
    cell, far = found['resolution'], BODY_RADIUS + OUTSIDE
    assert far >= found['robot_radius'] + hypot(PADDING, PADDING) + hypot(cell, cell)
    assert far + LEFT_BEHIND < layer['contacts.obstacle_max_range']


def wheel(speed: float, turn: float) -> float:
    """Return the speed of the faster wheel, m/s, for m/s forward and rad/s."""
    return abs(speed) + abs(turn) * Parameters.wheel_separation / 2


def test_nav2_commands_only_possible_speeds():
    smoother = nav2('velocity_smoother')
    for limit in ('max_velocity', 'min_velocity'):
        speed, sideways, turn = smoother[limit]
        assert sideways == 0
        assert wheel(speed, turn) <= Parameters.max_wheel_speed
    follow = {name.removeprefix('FollowPath.'): value
              for name, value in nav2('controller_server').items()}
    assert follow['desired_linear_vel'] <= smoother['max_velocity'][0]
    assert follow['rotate_to_heading_angular_vel'] <= smoother['max_velocity'][2]
    assert nav2('behavior_server')['max_rotational_vel'] <= smoother['max_velocity'][2]
    stamped = [nav2(node).get('enable_stamped_cmd_vel') for node in nodes('nav2.yaml')]
    assert stamped.count(False) == 5 and True not in stamped  # all the same
    assert f'/{nav2("collision_monitor")["cmd_vel_out_topic"]}' in OURS


def test_a_stick_commands_only_possible_speeds_and_often_enough():
    stick = nodes('teleop_twist_joy.yaml')['teleop_twist_joy_node']
    assert stick['publish_stamped_twist'] is False  # as in nav2.yaml
    assert stick['scale_linear.x'] < stick['scale_linear_turbo.x'] <= Parameters.max_wheel_speed
    assert stick['scale_angular.yaw'] < stick['scale_angular_turbo.yaw']
    assert wheel(0, stick['scale_angular_turbo.yaw']) <= Parameters.max_wheel_speed
    repeated = nodes('teleop_twist_joy.yaml')['game_controller_node']['autorepeat_rate']
    assert repeated * Parameters.cmd_vel_timeout > 2


def test_every_status_of_the_driver_is_in_one_group():
    names = re.findall(r"f'\{name\}: ([a-z ]+)'", Path(diagnostics.__file__).read_text('utf-8'))
    names += [diagnostics.LINK, diagnostics.PARAMETERS]
    analyzers = nodes('diagnostic_aggregator.yaml')['analyzers']
    groups = [value for name, value in analyzers.items() if name.endswith('.contains')]
    for name in set(names):
        within = [group for group in groups if any(each in f'create: {name}' for each in group)]
        assert len(within) == 1, name


def kind_of(path: str) -> str:
    """Return the type of a field, given its path such as `/odom.twist.twist.linear.x`."""
    topic, *fields = path.removeprefix('/').split('.')
    value: Any = TYPES[topic]()
    for field in fields[:-1]:
        value = getattr(value, field)
    return value.get_fields_and_field_types()[fields[-1]]


def test_the_foxglove_layout_names_what_exists_and_drives_within_the_limits():
    layout = json.loads((FILES / 'foxglove.json').read_text('utf-8'))
    panels = layout['configById']
    assert shown(layout['layout']) == set(panels)
    for name, panel in panels.items():
        for path in panel.get('paths', ()):
            kind = kind_of(path['value'])
            assert kind == 'double' or kind == 'float' or name.startswith('StateTransitions')
        for topic in (*panel.get('topics', ()), panel.get('topicToRender'), panel.get('topic')):
            assert topic is None or topic in OURS
        for layer in panel.get('layers', {}).values():
            assert layer.get('topic', '/odom') in OURS | FOREIGN
            assert layer.get('frameId', Parameters.odom_frame) == Parameters.odom_frame
    pad = panels['Teleop!drive']
    assert pad['publishRate'] * Parameters.cmd_vel_timeout > 2
    up, left = pad['upButton'], pad['leftButton']
    assert (up['field'], left['field']) == ('linear-x', 'angular-z')
    assert wheel(up['value'], left['value']) <= Parameters.max_wheel_speed


def shown(place: Any) -> set[str]:
    """Return the names of all panels in a layout."""
    if isinstance(place, str):
        return {place}
    return shown(place['first']) | shown(place['second'])


def test_the_service_starts_an_existing_launch_file():
    unit = ConfigParser(strict=False, interpolation=None)  # the last value of a repeated key
    unit.read(FILES / 'create.service')
    shell, option, line = shlex.split(unit['Service']['ExecStart'])
    assert (shell, option, unit['Service']['KillSignal']) == ('/bin/bash', '-c', 'SIGINT')
    *sourced, last = line.split(' && ')
    assert all(each.startswith('source /') for each in sourced)
    assert tuple(shlex.split(last.removeprefix('exec ').replace(
        '/dev/create', 'PORT'))) in ros2_commands()
    if shutil.which('systemd-analyze'):
        checked = subprocess.run(['systemd-analyze', 'verify', FILES / 'create.service'],
                                 text=True, capture_output=True, timeout=60)
        assert checked.returncode == 0 and 'create.service' not in checked.stderr


# The model and the parameter file.


LINKS = {link.get('name') for link in MODEL.iter('link')}
JOINTS = {joint.get('name'): joint for joint in MODEL.iter('joint')}


def ends(joint: ElementTree.Element) -> tuple[str, str]:
    """Return the parent and the child of a joint."""
    return joint.find('parent').get('link'), joint.find('child').get('link')


def canonical(text: str) -> str:
    return ElementTree.canonicalize(text, strip_text=True)


def numbers(element: ElementTree.Element, name: str) -> list[float]:
    """Return the numbers of an attribute."""
    return [float(number) for number in element.get(name, '').split()]


def test_the_model_is_a_tree_that_begins_on_the_floor():
    children = [ends(joint)[1] for joint in JOINTS.values()]
    assert len(children) == len(set(children))
    assert LINKS - set(children) == {Parameters.base_frame}
    assert {parent for joint in JOINTS.values() for parent in ends(joint)} <= LINKS


def test_the_wheels_are_those_of_the_joint_states_and_of_the_odometry():
    left, right = (JOINTS[name] for name in WHEEL_JOINTS)
    for joint in (left, right):
        assert joint.get('type') == 'continuous'
        assert numbers(joint.find('axis'), 'xyz') == [0, 1, 0]
    apart = numbers(left.find('origin'), 'xyz')[1] - numbers(right.find('origin'), 'xyz')[1]
    assert apart == pytest.approx(Geometry().wheel_separation)
    for wheel in ('left_wheel_link', 'right_wheel_link'):
        link = next(link for link in MODEL.iter('link') if link.get('name') == wheel)
        radii = {float(cylinder.get('radius')) for cylinder in link.iter('cylinder')}
        assert radii == {Geometry().wheel_radius}


def of_xacro(*arguments: str) -> str:
    """Return the model that xacro makes."""
    return subprocess.run(
        [sys.executable, '-c', 'import xacro; xacro.main()', f'{URDF}.xacro', *arguments],
        text=True, capture_output=True, check=True).stdout


def test_the_model_is_made_from_the_xacro():
    assert canonical(of_xacro()) == canonical(URDF.read_text()), 'run `make docs`'


def test_the_xacro_takes_a_prefix_and_a_parent():
    model = ElementTree.fromstring(of_xacro('prefix:=left_', 'parent:=stage'))
    assert {link.get('name') for link in model.iter('link')} == {f'left_{link}' for link in LINKS}
    joints = {joint.get('name'): ends(joint) for joint in model.iter('joint')}
    assert joints['left_parent_joint'] == ('stage', 'left_base_footprint')
    assert set(joints) == {'left_parent_joint', *(f'left_{joint}' for joint in JOINTS)}


def test_the_parameter_file_is_made_from_the_code():
    text = (ROOT / 'config' / 'create.yaml').read_text()
    assert text == config(), 'run `make docs`'
    values = yaml.safe_load(text)['/**']['ros__parameters']
    defaults = {name: list(field.default) if isinstance(field.default, tuple) else field.default
                for name, field in Parameters.__dataclass_fields__.items()}
    assert values == defaults
    assert {name: type(value) for name, value in values.items()} == {
        name: type(value) for name, value in defaults.items()}
