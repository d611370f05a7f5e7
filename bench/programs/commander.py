"""
Publishes velocities that can be told apart, at moments that cannot be foretold: `commander.py N`.

It waits for a subscriber first. At the end it prints pairs of time (monotonic clock, seconds,
just before publishing) and the speed that was asked for, mm/s.
"""

import json
from random import Random
import sys
from time import monotonic, sleep

from geometry_msgs.msg import Twist
import rclpy

SLOWEST = 100
"""mm/s; every command is one faster than that before it."""
rclpy.init()
node = rclpy.create_node('commander')
publisher = node.create_publisher(Twist, 'cmd_vel', 1)
print('speaks', flush=True)
while not publisher.get_subscription_count():
    sleep(0.05)
chance = Random(1)
said = []
for speed in range(SLOWEST, SLOWEST + int(sys.argv[1])):
    sleep(chance.uniform(0.03, 0.06))
    twist = Twist()
    twist.linear.x = speed / 1000
    said.append((monotonic(), speed))
    publisher.publish(twist)
print(json.dumps(said), flush=True)
