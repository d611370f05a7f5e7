# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Drive a square without ROS, by time and requested speeds.

    python examples/oi_square.py /dev/ttyUSB0
"""
import argparse
from math import pi
import termios
import time

import serial

from create_oi_ros import oi
from create_oi_ros.robot import MM_PER_M, WHEEL_SEPARATION

SIDE = 500  # mm
SPEED, TURN_SPEED = 200, 100  # mm/s of each wheel
QUARTER = WHEEL_SEPARATION * MM_PER_M / 2 * pi / 2  # mm that each wheel drives in a quarter turn
MOTION = oi.PacketList(['distance', 'angle'])
ATTEMPTS = 10


def drive(port: serial.Serial, right: int, left: int, distance: float) -> None:
    """Let the faster wheel drive a distance, then stop and wait until the robot stands."""
    port.write(bytes(oi.DriveDirect(right=right, left=left)))
    time.sleep(distance / max(abs(right), abs(left)))
    port.write(bytes(oi.DriveDirect(right=0, left=0)))
    time.sleep(0.5)


def reading(port: serial.Serial) -> oi.Readings:
    """Ask how far the robot has moved since it was asked last; ask again if bytes are lost."""
    for _ in range(ATTEMPTS):
        port.reset_input_buffer()
        port.write(bytes(oi.QueryList(packets=MOTION.ids)))
        reply = port.read(MOTION.reply_size)
        if len(reply) == MOTION.reply_size:
            return MOTION.unpack_reply(reply)
        print('no whole reply, asking again: what the robot counted is lost with it')
    raise SystemExit('the robot does not answer: is it switched on, and the cable in?')


def main(port: serial.Serial) -> None:
    """Drive four sides; the robot stands, and is in Passive, at the end."""
    for command in (oi.Start(), oi.Safe()):
        port.write(bytes(command))
        time.sleep(0.02)  # without this pause a robot may lose the next command
    try:
        reading(port)  # what it moved before
        for side in range(1, 5):
            drive(port, SPEED, SPEED, SIDE)
            drive(port, TURN_SPEED, -TURN_SPEED, QUARTER)
            moved = reading(port)
            print(f'side {side}: the robot counted {moved.distance} mm and {moved.angle} degrees')
    finally:
        port.write(bytes(oi.DriveDirect(right=0, left=0)) + bytes(oi.Start()))


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description='Drive a square of half a metre.')
    parser.add_argument('port', help='serial device of the robot, such as /dev/ttyUSB0')
    try:
        with serial.serial_for_url(parser.parse_args().port, 57600, timeout=0.3) as robot:
            main(robot)
    except (OSError, termios.error) as error:  # no such port, no permission, or pulled out
        raise SystemExit(f'{error}; is the cable in, and are you in the group dialout?') from None
    except KeyboardInterrupt:
        raise SystemExit('stopped') from None
