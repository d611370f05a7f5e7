# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A simulated Create with the nodes of create.launch.py; on request its lidar.

    ros2 launch create_oi_ros simulation.launch.py rviz:=true
"""

import os
import tempfile

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    IncludeLaunchDescription,
    Shutdown,
)
from launch.conditions import IfCondition
from launch.substitutions import EnvironmentVariable, LaunchConfiguration, PythonExpression
from launch_ros.actions import Node, PushRosNamespace
from launch_ros.substitutions import ExecutableInPackage

CREATE = os.path.join(
    get_package_share_directory('create_oi_ros'), 'launch', 'create.launch.py')


def generate_launch_description():
    """Declare the arguments and start all, in a group: no default reaches other files."""
    # Path of the robot's port, by ROS domain and namespace, such as /tmp/create_0.robot1
    robot = [
        os.path.join(tempfile.gettempdir(), 'create_'),
        EnvironmentVariable('ROS_DOMAIN_ID', default_value='0'),
        PythonExpression(
            ["'", LaunchConfiguration('ros_namespace'), "'.rstrip('/').replace('/', '.')"])]
    control = [*robot, '-control']
    tf = LaunchConfiguration('tf')
    return LaunchDescription([GroupAction([
        DeclareLaunchArgument(
            'world', default_value='apartment',
            description='world of the robot: a file, or a name of `create_sim --help`'),
        DeclareLaunchArgument(
            'lidar', default_value='false', choices=['true', 'false', 'True', 'False'],
            description='true: give the robot a lidar, for SLAM and Nav2'),
        DeclareLaunchArgument(
            'namespace', default_value='', description='namespace of all nodes and topics'),
        DeclareLaunchArgument(
            'tf', default_value='/tf',
            description='topic of the transforms; tf: below the namespace'),
        PushRosNamespace(LaunchConfiguration('namespace')),
        # The first, for it may fail: launch leaves running what it started before an error.
        IncludeLaunchDescription(CREATE, launch_arguments={
            'namespace': '', 'port': robot, 'control': control, 'simulated': 'false'}.items()),
        ExecuteProcess(
            # --linger: it waits for the driver's last stop; launch would kill it after 5 s.
            cmd=[ExecutableInPackage('create_sim', 'create_oi_ros'), '--link', robot,
                 '--world', LaunchConfiguration('world'), '--gyro', '--control', control,
                 '--linger', '3'],
            name='create_sim', output='screen', on_exit=Shutdown(reason='create_sim has ended')),
        Node(
            package='create_oi_ros', executable='create_lidar', output='screen',
            condition=IfCondition(LaunchConfiguration('lidar')),
            remappings=[('/tf', tf), ('/tf_static', [tf, '_static'])],
            arguments=['--control', control]),
    ])])
