# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Play a tune of any length: here a ring tone (RTTTL)."""
import argparse

from rclpy.utilities import remove_ros_args

from create_oi_ros.ros.goal_client import GoalClient, GoalFailed

TUNE = ('joy:d=4,o=5,b=180:e,e,f,g,g,f,e,d,c,c,d,e,e.,8d,2d,'
        'e,e,f,g,g,f,e,d,c,c,d,e,d.,8c,2c')

argparse.ArgumentParser(description=__doc__).parse_args(remove_ros_args()[1:])
try:
    with GoalClient() as robot:
        print(robot.do('audio_note_sequence', notes=TUNE).message, flush=True)
except GoalFailed as why:
    raise SystemExit(str(why)) from None
