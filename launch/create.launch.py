# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
One Create: its driver and model, and on request a simulated robot, its web page and RViz.

    ros2 launch create_oi_ros create.launch.py port:=/dev/ttyUSB0
    ros2 launch create_oi_ros create.launch.py simulated:=true rviz:=true
    ros2 launch create_oi_ros create.launch.py simulated:=true web:=true
"""

import os
import shutil
import tempfile
import uuid

from ament_index_python.packages import (
    get_package_prefix,
    get_package_share_directory,
    PackageNotFoundError,
)
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    GroupAction,
    OpaqueFunction,
    RegisterEventHandler,
)
from launch.conditions import IfCondition, UnlessCondition
from launch.event_handlers import OnProcessExit, OnProcessIO
from launch.events import Shutdown
from launch.substitutions import (
    AndSubstitution,
    EqualsSubstitution,
    IfElseSubstitution,
    LaunchConfiguration,
    NotSubstitution,
)
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from create_oi_ros.sim.world_files import read_world

SHARE = get_package_share_directory('create_oi_ros')
ARGUMENTS = {
    'port': ('/dev/ttyUSB0', 'serial device of the robot, or a pyserial URL'),
    'simulated': ('false', 'true: simulate the robot, on a pseudo terminal'),
    'world': ('apartment', 'world of the simulated robot: a name, or a file'),
    'lidar': ('false', 'true: give the simulated robot a lidar, for SLAM and Nav2'),
    'gyro': ('none', 'analog: a gyro is on the analog input; a simulated robot gets one'),
    'namespace': ('', 'namespace of all nodes and topics'),
    'frame_prefix': ('', 'put before every frame, such as robot1/'),
    'tf': ('/tf', 'topic of the transforms; tf: below the namespace'),
    'capture': ('', 'file to write every byte of the serial line to'),
    'params': (os.path.join(SHARE, 'config', 'create.yaml'), 'parameter file of the driver'),
    'use_sim_time': ('false', 'true: take the time from /clock'),
    'log_level': ('info', 'of the driver'),
    'respawn': ('false', 'true: start the driver again when it ends; false: the launch ends'),
    'description': ('true', 'true: publish the model and its frames (robot_state_publisher)'),
    'rviz': ('false', 'true: open RViz'),
    'web': ('false', 'true: serve a page that shows the robot and drives it (create_web)'),
    'host': ('127.0.0.1', 'address on which the page is served; 0.0.0.0: with a token'),
}
CHOICES = {
    **dict.fromkeys(
        ('simulated', 'lidar', 'use_sim_time', 'respawn', 'description', 'rviz', 'web'),
        ['true', 'false']),
    'gyro': ['none', 'analog'],
    'log_level': ['debug', 'info', 'warn', 'error', 'fatal'],
}
# Launch leaves its processes running when it fails. These end with it, however it ends.
ENDS_WITH_LAUNCH = [
    'setpriv --pdeathsig TERM ' if shutil.which('setpriv') else '',
    LaunchConfiguration('launch-prefix', default='')]
LINGER = '3'  # seconds that the simulated robot waits for the driver's stop; launch kills after 5


def generate_launch_description():
    """Declare the arguments, check them, and start the nodes."""
    value = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    robot = os.path.join(tempfile.gettempdir(), f'create_{uuid.uuid4().hex[:8]}')
    simulator = simulated_robot(robot, value)
    driver = driver_node(robot, value)
    return LaunchDescription([
        *(DeclareLaunchArgument(
            name, default_value=default, description=description, choices=CHOICES.get(name))
          for name, (default, description) in ARGUMENTS.items()),
        OpaqueFunction(function=check),
        # The driver of a simulated robot starts when its port is there.
        RegisterEventHandler(OnProcessIO(target_action=simulator, on_stdout=once(driver))),
        RegisterEventHandler(
            OnProcessExit(target_action=driver,
                          on_exit=EmitEvent(event=Shutdown(reason='create_node has ended'))),
            condition=UnlessCondition(value['respawn'])),
        simulator,
        GroupAction([driver], scoped=False, condition=UnlessCondition(value['simulated'])),
        page(value, AndSubstitution(value['web'], value['simulated']),
             '--control', f'{robot}.control'),
        page(value, AndSubstitution(value['web'], NotSubstitution(value['simulated']))),
        lidar(robot, value), model(value), rviz(value)])


def once(action):
    """Return a handler that starts an action at the first event."""
    waiting = [action]
    return lambda event: [waiting.pop()] if waiting else []


def simulated_robot(robot, value):
    """Return the simulated robot; it is no ROS node and takes no --ros-args."""
    program = os.path.join(
        get_package_prefix('create_oi_ros'), 'lib', 'create_oi_ros', 'create_sim')
    return ExecuteProcess(
        cmd=[program, '--link', robot, '--world', value['world'], '--linger', LINGER,
             '--control', f'{robot}.control', '--guess',
             IfElseSubstitution(EqualsSubstitution(value['gyro'], 'analog'), 'gyro=1', 'gyro=0')],
        name='create_sim', output='screen', prefix=ENDS_WITH_LAUNCH,
        condition=IfCondition(value['simulated']),
        on_exit=EmitEvent(event=Shutdown(reason='create_sim has ended')))


def node(program, value, package=None, **options):
    """Return a node of this launch."""
    return Node(
        package=package or program, executable=program, exec_name=program,
        namespace=value['namespace'], prefix=ENDS_WITH_LAUNCH,
        remappings=[('/tf', value['tf']), ('/tf_static', [value['tf'], '_static'])], **options)


def driver_node(robot, value):
    """Return the driver."""
    def text(name):  # else launch reads it as YAML: an empty one is no text
        return ParameterValue(value[name], value_type=str)
    return node(
        'create_node', value, 'create_oi_ros', output='screen',
        ros_arguments=['--log-level', value['log_level']],
        respawn=value['respawn'], respawn_delay=2.0,
        parameters=[value['params'], {
            'port': ParameterValue(
                IfElseSubstitution(value['simulated'], robot, value['port']), value_type=str),
            'odom_frame': ParameterValue([value['frame_prefix'], 'odom'], value_type=str),
            'base_frame': ParameterValue(
                [value['frame_prefix'], 'base_footprint'], value_type=str),
            'gyro': text('gyro'), 'capture': text('capture'), **clock(value)}])


def page(value, condition, *options):
    """Return the web page."""
    return node('create_web', value, 'create_oi_ros', output='screen',
                arguments=['--host', value['host'], *options], condition=IfCondition(condition))


def lidar(robot, value):
    """Return the publisher of the simulated robot's scans."""
    return node('create_lidar', value, 'create_oi_ros', output='screen',
                arguments=['--control', f'{robot}.control',
                           '--frame', [value['frame_prefix'], 'laser'],
                           '--base-frame', [value['frame_prefix'], 'base_footprint']],
                condition=IfCondition(AndSubstitution(value['simulated'], value['lidar'])))


def model(value):
    """Return the publisher of the model and its frames."""
    with open(os.path.join(SHARE, 'urdf', 'create.urdf')) as urdf:
        return node(
            'robot_state_publisher', value, condition=IfCondition(value['description']),
            parameters=[{'robot_description': ParameterValue(urdf.read(), value_type=str),
                         'frame_prefix': ParameterValue(value['frame_prefix'], value_type=str),
                         **clock(value)}])


def rviz(value):
    """Return RViz."""
    return node(
        'rviz2', value, condition=IfCondition(value['rviz']), parameters=[clock(value)],
        arguments=['-d', os.path.join(SHARE, 'rviz', 'create.rviz'),
                   '-f', [value['frame_prefix'], 'odom']])


def clock(value):
    """Return the parameter by which a node chooses its clock."""
    return {'use_sim_time': ParameterValue(value['use_sim_time'], value_type=bool)}


def check(context):
    """Raise RuntimeError if an argument is wrong or asks for what is missing: nothing starts."""
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    for name, package in (('description', 'robot_state_publisher'), ('rviz', 'rviz2')):
        if value[name] == 'true':
            check_installed(package, name)
    try:
        open(value['params']).close()
    except OSError as error:
        raise RuntimeError(f'params:={value["params"]}: {error.strerror}') from None
    if value['simulated'] == 'true':
        try:
            read_world(value['world'])
        except ValueError as error:
            raise RuntimeError(f'world:={error}') from None
    elif value['lidar'] == 'true':
        raise RuntimeError('lidar:=true is for simulated:=true: a real lidar has its own driver')
    elif not value['port']:
        raise RuntimeError('port:= is empty; allowed: a serial device or a pyserial URL')


def check_installed(package, argument):
    """Raise RuntimeError if a package is missing."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        raise RuntimeError(
            f'{package} is not installed: sudo apt-get install '
            f'ros-jazzy-{package.replace("_", "-")}, or launch with {argument}:=false') from None
