# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Several simulated Creates: robot1, robot2, ... Each has a namespace and frames of its own.

    ros2 launch create_oi_ros fleet.launch.py count:=3

All other arguments are those of simulation.launch.py, and hold for each robot.
"""

import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    OpaqueFunction,
)

SIMULATION = os.path.join(
    get_package_share_directory('create_oi_ros'), 'launch', 'simulation.launch.py')
MOST = 20  # each takes a twentieth of a core


def generate_launch_description():
    """Declare the number of robots, and start them."""
    return LaunchDescription([
        DeclareLaunchArgument(
            'count', default_value='2', choices=[str(n) for n in range(1, MOST + 1)],
            description='number of robots; other arguments are those of simulation.launch.py'),
        OpaqueFunction(function=robots)])


def robots(context):
    """Return the robots; a group each, so that no argument of one reaches the next."""
    count = int(context.launch_configurations['count'])
    return [
        GroupAction([IncludeLaunchDescription(SIMULATION, launch_arguments={
            'namespace': f'robot{number}', 'frame_prefix': f'robot{number}/'}.items())])
        for number in range(1, count + 1)]
