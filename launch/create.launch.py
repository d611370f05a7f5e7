# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The driver of a Create, and its model; on request its web page and RViz.

    ros2 launch create_oi_ros create.launch.py port:=/dev/ttyUSB0

For a simulated robot: simulation.launch.py, which includes this file.
"""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, PushRosNamespace
from launch_ros.parameter_descriptions import ParameterValue

SHARE = get_package_share_directory('create_oi_ros')
BOOLEAN = ['true', 'false', 'True', 'False']


def generate_launch_description():
    """Declare the arguments and start the nodes, in a group: no default reaches other files."""
    return LaunchDescription([GroupAction([
        DeclareLaunchArgument(
            'port', default_value='',
            description='serial device of the robot, or a pyserial URL; empty: as in params'),
        DeclareLaunchArgument(
            'params', default_value=os.path.join(SHARE, 'config', 'create.yaml'),
            description='parameter file of the driver; arguments that are given win over it'),
        DeclareLaunchArgument(
            'namespace', default_value='', description='namespace of all nodes and topics'),
        DeclareLaunchArgument(
            'frame_prefix', default_value='',
            description='put before every frame, such as robot1/; empty: frames as in params'),
        DeclareLaunchArgument(
            'tf', default_value='/tf',
            description='topic of the transforms; tf: below the namespace'),
        DeclareLaunchArgument(
            'gyro', default_value='',
            description='analog: a gyro is on the analog input; none; empty: as in params'),
        DeclareLaunchArgument(
            'capture', default_value='',
            description='file to write every byte of the serial line to; empty: as in params'),
        DeclareLaunchArgument(
            'use_sim_time', default_value='', choices=['', *BOOLEAN],
            description='true: take the time from /clock; empty: as in params'),
        DeclareLaunchArgument(
            'log_level', default_value='info',
            description='of the driver: debug, info, warn, error, fatal'),
        DeclareLaunchArgument(
            'respawn', default_value='false', choices=BOOLEAN,
            description='true: start the driver again when it ends; false: the launch ends'),
        DeclareLaunchArgument(
            'description', default_value='true', choices=BOOLEAN,
            description='true: publish the model and its frames (robot_state_publisher)'),
        DeclareLaunchArgument(
            'rviz', default_value='false', choices=BOOLEAN, description='true: open RViz'),
        DeclareLaunchArgument(
            'web', default_value='false', choices=BOOLEAN,
            description='true: serve a page that shows the robot and drives it (create_web)'),
        DeclareLaunchArgument(
            'host', default_value='127.0.0.1',
            description='address on which the page is served; 0.0.0.0: with a token'),
        DeclareLaunchArgument(
            'control', default_value='',
            description='control socket of a simulated robot, whose room the page then shows'),
        PushRosNamespace(LaunchConfiguration('namespace')),
        OpaqueFunction(function=nodes),
    ])])


def nodes(context):
    """
    Return the nodes. Only an argument that was given becomes a parameter, and wins over the file.

    The driver is the last: launch leaves running what it started before an error, such as that
    of a package that is not installed.
    """
    value = context.launch_configurations
    if value.get('simulated', '').lower() in ('true', '1'):
        raise RuntimeError('simulated:=true: create.launch.py is for a real robot; launch '
                           'simulation.launch.py')
    prefix, respawn = value['frame_prefix'], value['respawn'].lower() == 'true'
    remaps = [('/tf', value['tf']), ('/tf_static', value['tf'] + '_static')]
    clock, given = {}, {name: value[name] for name in ('port', 'gyro', 'capture') if value[name]}
    if value['use_sim_time']:
        clock['use_sim_time'] = value['use_sim_time'].lower() == 'true'
    if prefix:
        given |= {'odom_frame': prefix + 'odom', 'base_frame': prefix + 'base_footprint'}
    with open(os.path.join(SHARE, 'urdf', 'create.urdf')) as urdf:
        model = {'robot_description': urdf.read(), 'frame_prefix': prefix}
    return [
        Node(
            package='rviz2', executable='rviz2', condition=IfCondition(value['rviz']),
            parameters=[clock], remappings=remaps,
            arguments=['-d', os.path.join(SHARE, 'rviz', 'create.rviz'), '-f', prefix + 'odom']),
        Node(
            package='robot_state_publisher', executable='robot_state_publisher',
            condition=IfCondition(value['description']),
            parameters=[clock, texts(model)], remappings=remaps),
        Node(
            package='create_oi_ros', executable='create_web', output='screen',
            condition=IfCondition(value['web']),
            arguments=['--host', value['host'],
                       *(['--control', value['control']] if value['control'] else [])]),
        Node(
            package='create_oi_ros', executable='create_node', output='screen',
            # The file is not in `parameters`, where launch only warns of one that is missing.
            ros_arguments=['--log-level', value['log_level'], '--params-file', value['params']],
            parameters=[clock, texts(given)], remappings=remaps,
            respawn=respawn, respawn_delay=2.0,
            on_exit=None if respawn else Shutdown(reason='create_node has ended')),
    ]


def texts(parameters):
    """Return parameters that stay texts; launch would read them as YAML."""
    return {name: ParameterValue(value, value_type=str) for name, value in parameters.items()}
