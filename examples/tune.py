# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Play a tune that is longer than a song of the robot, which has sixteen notes at most."""
import argparse

from create_oi_msgs.msg import Song
from create_oi_msgs.srv import DefineSong
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.utilities import remove_ros_args

from create_oi_ros.ros.waiting import wait_for_robot

TUNE = 'E4 E4 F4 G4 G4 F4 E4 D4 C4 C4 D4 E4 E4 D4 D4 E4 E4 F4 G4 G4 F4 E4 D4 C4 C4 D4 E4 D4 C4 C4'
PITCHES = [12 + 12 * int(note[1]) + 'C D EF G A B'.index(note[0]) for note in TUNE.split()]

argparse.ArgumentParser(description=__doc__).parse_args(remove_ros_args()[1:])
rclpy.init()
node = rclpy.create_node('tune')
define = node.create_client(DefineSong, 'define_song')
playing: list[bool] = []
node.create_subscription(
    Song, 'song', lambda song: playing.append(song.playing),
    QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
wait_for_robot(node, define.service_is_ready)
for start in range(0, len(PITCHES), 16):
    part = PITCHES[start:start + 16]
    asked = define.call_async(DefineSong.Request(
        number=start // 16 % 2, pitches=part, seconds=[0.25] * len(part), play=True))
    rclpy.spin_until_future_complete(node, asked)
    print(asked.result().message, flush=True)
    playing.clear()
    while not playing or playing[-1]:  # until the robot reports the end of this part
        rclpy.spin_once(node)
