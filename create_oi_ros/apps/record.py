# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_record`: record the driver's topics and its commands to a bag, until Ctrl-C."""

from __future__ import annotations

import argparse
from datetime import datetime
import os
from pathlib import Path
import sys

import rclpy
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

from ..ros.bags import Recorder
from ..ros.process import call_on_signal, ros_executor, spin_until
from ..ros.waiting import say_if_waiting


def say(text: str, before: str = '', after: str = '\n') -> None:
    """Print a line and flush it."""
    print(f'{before}create_record: {text}', end=after, flush=True)


def amount(recorder: Recorder) -> str:
    """Return how much is recorded, in words."""
    return (f'{recorder.counts.total()} messages of {len(recorder.counts)} topics, '
            f'{recorder.size / 1e6:.1f} MB')


def record(folder: Path, ended: Future) -> Recorder | None:
    """Record until `ended` is done; None: the disk is full; OSError: the folder cannot be made."""
    with ros_executor() as executor:
        node = rclpy.create_node('create_record')
        executor.add_node(node)
        recorder = Recorder(node, folder)
        say(f'records {", ".join(each.name for each in recorder.topics)} to {folder} until Ctrl-C')
        if sys.stdout.isatty():
            node.create_timer(1.0, lambda: say(amount(recorder), '\r', ' '))
        say_if_waiting(node, 'a driver', lambda: not recorder.counts,
                       lambda why: say(why, '\r' if sys.stdout.isatty() else ''))
        try:
            spin_until(executor, ended)
            recorder.close()
        except OSError as error:
            say(f'recording has ended: {error}', '\n' if sys.stdout.isatty() else '')
            say(f'all but the last second is in {folder}; create_report reads it')
            return None
    return recorder


def main() -> int:
    """Run `create_record`; 1: the disk is full, or no message came. OSError: see `record`."""
    parser = argparse.ArgumentParser(
        prog='create_record', description='Record everything that the driver publishes, and its '
        'commands, to a bag (rosbag 2, MCAP) until Ctrl-C.',
        epilog='A robot in a namespace: --ros-args -r __ns:=/robot1')
    parser.add_argument('-o', dest='folder', type=Path, metavar='FOLDER',
                        default=Path(f'record-{datetime.now():%Y%m%d-%H%M%S}'),
                        help='a new folder for the bag (default: record-DATE-TIME)')
    options = parser.parse_args(remove_ros_args(sys.argv)[1:])
    if options.folder.exists():
        parser.error(f'{options.folder} is there already')
    ended = Future()
    call_on_signal(lambda: ended.set_result(0))
    recorder = record(options.folder, ended)
    if recorder is None:
        return 1
    # On a terminal, overwrite the line with the running count.
    say(f'{amount(recorder)} are in {options.folder}', '\r' if sys.stdout.isatty() else '')
    if not recorder.counts:
        say('nothing was heard in ROS domain ' + (os.environ.get('ROS_DOMAIN_ID') or '0'))
        return 1
    if missing := [each.name for each in recorder.topics if not each.count]:
        say(f'nothing was recorded of {", ".join(missing)}')
    return 0
