# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Upload a script with waits to the robot without ROS, and play it.

    python examples/oi_script.py /dev/ttyUSB0
"""
import argparse
import termios
import time

import serial

from create_oi_ros import oi
from create_oi_ros.oi.script import can_end, open_waits
from create_oi_ros.oi.tools.text import format_command, parse_script

SCRIPT = parse_script("""
    Drive velocity=200 radius=straight
    Wait Distance distance=300
    Drive velocity=100 radius=in_place_counter_clockwise
    Wait Angle angle=90
    Drive velocity=0 radius=straight
    Wait Time time=10
""")
MODE = oi.PacketList(['oi_mode'])
ATTEMPTS = 10
LONGEST = 30.0
"""Seconds that the script takes at most."""
GONE = 'the robot does not answer: is it switched on, and the cable in?'


def upload(port: serial.Serial) -> None:
    """Store the script, and read it back, until the robot has it."""
    for _ in range(ATTEMPTS):
        port.reset_input_buffer()
        port.write(bytes(SCRIPT) + bytes(oi.ShowScript()))
        reply = port.read(1 + len(SCRIPT.script))
        if reply == bytes(SCRIPT)[1:]:
            return
    raise SystemExit('the robot has stored something else: is the line good?' if reply else GONE)


def play(port: serial.Serial) -> float:
    """Play the script; return how many seconds it took."""
    start = time.monotonic()
    port.write(bytes(oi.PlayScript()))
    while not port.read(MODE.reply_size):  # while a script waits, the robot answers nothing
        if time.monotonic() - start > LONGEST:
            raise SystemExit(GONE)
        port.write(bytes(oi.Sensors(packet='oi_mode')))
    return time.monotonic() - start


def main(port: serial.Serial) -> None:
    """Upload and play; the robot is in Passive at the end."""
    for command in (oi.Start(), oi.Safe()):
        port.write(bytes(command))
        time.sleep(0.02)  # without this pause a robot may lose the next command
    upload(port)
    print('the script can end' if can_end(SCRIPT) else 'only the power button stops the script')
    for wait in open_waits(SCRIPT):
        print(f'until this has happened, even a stop is ignored: {format_command(wait)}')
    try:
        print(f'the script took {play(port):.1f} s')
    finally:
        port.write(bytes(oi.DriveDirect(right=0, left=0)) + bytes(oi.Start()))


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description='Store a script in the robot, and play it.')
    parser.add_argument('port', help='serial device of the robot, such as /dev/ttyUSB0')
    try:
        with serial.serial_for_url(parser.parse_args().port, 57600, timeout=0.3) as robot:
            main(robot)
    except (OSError, termios.error) as error:  # no such port, no permission, or pulled out
        raise SystemExit(f'{error}; is the cable in, and are you in the group dialout?') from None
    except KeyboardInterrupt:
        raise SystemExit('stopped; a script that waits goes on until its wait is over') from None
