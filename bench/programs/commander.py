# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Publishes N velocity commands, each with another speed, at random times: `commander.py N`.

It waits for a subscriber first, and until its robot must obey. At the end it prints a JSON list of
pairs: the time just before publishing (monotonic clock, seconds) and the speed, mm/s.
"""

import json
from random import Random
import sys
from time import monotonic, sleep

from geometry_msgs.msg import Twist
import rclpy

SLOWEST = 100
"""Speed of the first command, mm/s; each next one is 1 mm/s faster."""
ENTERED = 2.0
"""Seconds from a driver's subscription until its robot obeys."""
rclpy.init()
node = rclpy.create_node('commander')
publisher = node.create_publisher(Twist, 'cmd_vel', 1)
while not publisher.get_subscription_count():
    sleep(0.05)
sleep(ENTERED)
random = Random(1)
published = []
for speed in range(SLOWEST, SLOWEST + int(sys.argv[1])):
    sleep(random.uniform(0.03, 0.06))
    twist = Twist()
    twist.linear.x = speed / 1000
    published.append((monotonic(), speed))
    publisher.publish(twist)
print(json.dumps(published), flush=True)
