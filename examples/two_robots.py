# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Drive a square with two robots at the same time, in the namespaces robot1 and robot2."""
import argparse
from math import pi

from rclpy.utilities import remove_ros_args

from create_oi_ros.ros.goal_client import GoalClient, GoalFailed

argparse.ArgumentParser(description=__doc__).parse_args(remove_ros_args()[1:])
try:
    with (GoalClient('client1', namespace='robot1') as one,
          GoalClient('client2', namespace='robot2') as two):
        for _ in range(4):
            for action, goal in (('drive_distance', {'distance': 0.3}),
                                 ('rotate_angle', {'angle': pi / 2})):
                for robot in (one, two):
                    robot.start(action, **goal)
                while not all([one.is_complete(), two.is_complete()]):
                    pass
                print('1:', one.result().message, ' 2:', two.result().message, flush=True)
except GoalFailed as why:
    raise SystemExit(str(why)) from None
