# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Upload a script with waits to the robot without ROS, and play it.

    python examples/oi_script.py /dev/ttyUSB0
"""
import sys
import time

import serial

from create_oi_ros import oi
from create_oi_ros.oi.script import can_end, open_waits, script_of_reply
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


def upload(port: serial.Serial) -> None:
    """Store the script, and read it back."""
    port.reset_input_buffer()
    port.write(bytes(SCRIPT) + bytes(oi.ShowScript()))
    stored = script_of_reply(port.read(1 + len(SCRIPT.script)))
    if stored != SCRIPT:
        raise SystemExit('the robot has stored something else: is the line good?')


def play(port: serial.Serial) -> float:
    """Play the script; return how many seconds it took."""
    start = time.monotonic()
    port.write(bytes(oi.PlayScript()))
    while not port.read(MODE.reply_size):  # while a script waits, the robot ignores all input
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
    print(f'the script took {play(port):.1f} s')
    port.write(bytes(oi.Start()))


if __name__ == '__main__':
    with serial.Serial(sys.argv[1], 57600, timeout=1) as robot:
        main(robot)
