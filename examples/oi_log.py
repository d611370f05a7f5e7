# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Log sensors to a CSV file without ROS, 66 rows a second, until Ctrl-C.

    python examples/oi_log.py /dev/ttyUSB0 sensors.csv
"""
import argparse
import csv
import termios
import time
from typing import TextIO

import serial

from create_oi_ros import oi

# Not distance and angle: read in every frame, they lose the fractions of millimetres and degrees.
PACKETS = oi.PacketList([
    'oi_mode', 'bumps_and_wheel_drops', 'wall_signal', 'cliff_left_signal',
    'cliff_front_left_signal', 'cliff_front_right_signal', 'cliff_right_signal', 'analog_signal',
    'voltage', 'current', 'requested_right_velocity', 'requested_left_velocity'])
SILENCE = 3.0
"""Seconds without a frame after which the robot is taken to be off."""


def log(port: serial.Serial, file: TextIO, rows: int | None = None) -> None:
    """Write so many rows, or rows for ever; the robot sends a frame every 15 ms."""
    table = csv.writer(file)
    table.writerow(['seconds', *PACKETS.names, 'analog_volts'])
    reader = oi.StreamReader([PACKETS])
    port.reset_input_buffer()
    port.write(bytes(oi.Start()))
    time.sleep(0.02)
    port.write(bytes(oi.Stream(packets=PACKETS.ids)))
    start, written = time.monotonic(), 0
    heard = start
    try:
        while rows is None or written < rows:
            reader.feed(port.read(max(1, port.in_waiting)))
            if time.monotonic() - heard > SILENCE:
                raise SystemExit(f'no frame for {SILENCE:.0f} s: is the robot switched on, and '
                                 'the cable in?')
            for event in reader:
                if isinstance(event, oi.Frame):
                    readings, heard = event.readings, time.monotonic()
                    table.writerow([
                        f'{heard - start:.3f}',
                        *(int(value) for _, value in readings.items()),
                        f'{readings.analog_volts:.3f}'])
                    written += 1
    finally:
        port.write(bytes(oi.PauseResumeStream(state=oi.StreamState.PAUSE)))


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description='Log sensors to a CSV file until Ctrl-C.')
    parser.add_argument('port', help='serial device of the robot, such as /dev/ttyUSB0')
    parser.add_argument('file', help='the file to write, such as sensors.csv')
    options = parser.parse_args()
    try:
        output = open(options.file, 'w', newline='')
    except OSError as error:
        parser.error(str(error))
    try:
        with output, serial.serial_for_url(options.port, 57600, timeout=1) as robot:
            log(robot, output)
    except (OSError, termios.error) as error:  # no such port, no permission, or pulled out
        raise SystemExit(f'{error}; is the cable in, and are you in the group dialout?') from None
    except KeyboardInterrupt:
        print(f'{options.file} written')
