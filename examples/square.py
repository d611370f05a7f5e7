# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Drive a square: each goal ends when the robot is there, or the program with the reason."""
import argparse
from math import pi

from rclpy.utilities import remove_ros_args

from create_oi_ros.ros.goal_client import GoalClient, GoalFailed

argparse.ArgumentParser(description=__doc__).parse_args(remove_ros_args()[1:])
try:
    with GoalClient() as robot:
        for _ in range(4):
            print(robot.do('drive_distance', distance=0.3).message, flush=True)
            print(robot.do('rotate_angle', angle=pi / 2).message, flush=True)
except GoalFailed as why:
    raise SystemExit(str(why)) from None
