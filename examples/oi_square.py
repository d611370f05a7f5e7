# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Drive a square without ROS, by time and requested speeds.

    python examples/oi_square.py /dev/ttyUSB0
"""
from math import pi
import sys
import time

import serial

from create_oi_ros import oi
from create_oi_ros.robot import MM_PER_M, WHEEL_SEPARATION

SIDE = 500  # mm
SPEED, TURN_SPEED = 200, 100  # mm/s of each wheel
QUARTER = WHEEL_SEPARATION * MM_PER_M / 2 * pi / 2  # mm that each wheel drives in a quarter turn
MOTION = oi.PacketList(['distance', 'angle'])


def drive(port: serial.Serial, right: int, left: int, distance: float) -> None:
    """Let the faster wheel drive a distance, then stop and wait until the robot stands."""
    port.write(bytes(oi.DriveDirect(right=right, left=left)))
    time.sleep(distance / max(abs(right), abs(left)))
    port.write(bytes(oi.DriveDirect(right=0, left=0)))
    time.sleep(0.5)


def reading(port: serial.Serial) -> oi.Readings:
    """Ask how far the robot has moved since it was asked last."""
    port.reset_input_buffer()
    port.write(bytes(oi.QueryList(packets=MOTION.ids)))
    return MOTION.unpack_reply(port.read(MOTION.reply_size))


def main(port: serial.Serial) -> None:
    """Drive four sides; the robot stands, and is in Passive, at the end."""
    for command in (oi.Start(), oi.Safe()):
        port.write(bytes(command))
        time.sleep(0.02)  # without this pause a robot may lose the next command
    reading(port)  # what it moved before
    try:
        for side in range(1, 5):
            drive(port, SPEED, SPEED, SIDE)
            drive(port, TURN_SPEED, -TURN_SPEED, QUARTER)
            moved = reading(port)
            print(f'side {side}: the robot counted {moved.distance} mm and {moved.angle} degrees')
    finally:
        port.write(bytes(oi.DriveDirect(right=0, left=0)) + bytes(oi.Start()))


if __name__ == '__main__':
    with serial.Serial(sys.argv[1], 57600, timeout=1) as robot:
        main(robot)
