# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Several simulated Creates: robot1, robot2, ... Each has a namespace and frames of its own.

    ros2 launch create_oi_ros fleet.launch.py count:=3
    ros2 topic pub -r 10 /robot2/cmd_vel geometry_msgs/msg/Twist '{linear: {x: 0.1}}'
"""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

SHARE = get_package_share_directory('create_oi_ros')


def robots(context):
    """Return the launch of a simulated robot, once for each."""
    text = LaunchConfiguration('count').perform(context)
    count = int(text) if text.isdecimal() else 0
    if not count:
        raise RuntimeError(f'count:={text}; allowed: a whole number of robots, 1 or more')
    one = os.path.join(SHARE, 'launch', 'create.launch.py')
    names = [f'robot{number}' for number in range(1, count + 1)]
    return [
        IncludeLaunchDescription(PythonLaunchDescriptionSource(one), launch_arguments={
            'simulated': 'true', 'namespace': name, 'frame_prefix': f'{name}/',
            'world': LaunchConfiguration('world'),
            'description': LaunchConfiguration('description')}.items())
        for name in names]


def generate_launch_description():
    """Declare the arguments and start the robots."""
    return LaunchDescription([
        DeclareLaunchArgument('count', default_value='2', description='number of robots'),
        DeclareLaunchArgument('world', default_value='apartment',
                              description='world of each robot'),
        DeclareLaunchArgument('description', default_value='true',
                              description='true: publish models (robot_state_publisher)'),
        OpaqueFunction(function=robots)])
