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


ARGUMENTS = {
    'world': ('apartment', 'world of each robot: a name, or a file'),
    'params': (os.path.join(SHARE, 'config', 'create.yaml'), 'parameter file of the drivers'),
    'log_level': ('info', 'of the drivers'),
    'use_sim_time': ('false', 'true: take the time from /clock'),
    'respawn': ('false', 'true: start a driver again when it ends; false: the launch ends'),
    'description': ('true', 'true: publish models (robot_state_publisher)'),
}


def robots(context):
    """Return the launch of a simulated robot, once for each."""
    text = LaunchConfiguration('count').perform(context)
    count = int(text) if text.isdecimal() else 0
    if not count:
        raise RuntimeError(f'count:={text}; allowed: a whole number of robots, 1 or more')
    one = os.path.join(SHARE, 'launch', 'create.launch.py')
    return [
        IncludeLaunchDescription(PythonLaunchDescriptionSource(one), launch_arguments={
            'simulated': 'true', 'namespace': name, 'frame_prefix': f'{name}/',
            **{argument: LaunchConfiguration(argument) for argument in ARGUMENTS}}.items())
        for name in (f'robot{number}' for number in range(1, count + 1))]


def generate_launch_description():
    """Declare the arguments and start the robots."""
    return LaunchDescription([
        DeclareLaunchArgument('count', default_value='2', description='number of robots'),
        *(DeclareLaunchArgument(name, default_value=default, description=description)
          for name, (default, description) in ARGUMENTS.items()),
        OpaqueFunction(function=robots)])
