# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `create_demo`: a simulated robot, its node, a tour, a bag, a report."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, ExitStack
from datetime import datetime
import os
from pathlib import Path
import subprocess
import threading
import time

import rclpy

from ...ros.bags import missing
from ...ros.goal_client import GoalFailed
from ...ros.process import call_on_signal, Children, ros_executor, start
from ...ros.programs import check_environment, INTERRUPTED
from ...ros.recorder import Recorder
from ...ros.simulated_run import run_domain, run_folder
from .pilot import Pilot, Stopped, TourError
from .tour import SHORT, TOUR, TourStep, WORLD

BAG = 'create_demo'
SIGN_INTERVAL = 8.0
"""Seconds after which a line says where the robot is: a step takes up to half a minute."""


def say(text: str) -> None:
    """Print a line and flush it."""
    print(f'create_demo: {text}', flush=True)


def tour(steps: Sequence[TourStep], pilot: Pilot) -> None:
    """Do all steps, and print each one."""
    began = time.monotonic()
    for number, step in enumerate(steps, 1):
        say(f'{time.monotonic() - began:5.1f} s  {number} of {len(steps)}: {step.title}')
        step.do(pilot)


@contextmanager
def recording(bag: Path, children: Children, stop: threading.Event) -> Iterator[Pilot]:
    """Record everything to a bag and yield the pilot; at the end, stop the children first."""
    shown = time.monotonic()

    def check() -> None:
        nonlocal shown
        if stop.is_set():
            raise Stopped
        if time.monotonic() - shown >= SIGN_INTERVAL:
            shown = time.monotonic()
            x, y = pilot.place
            say(f'         the robot is at x {x:+z.2f} y {y:+z.2f} m')
        ended = children.ended()
        if ended is not None:
            raise TourError(f'{ended}; see above for why')

    with ros_executor() as executor:
        node = rclpy.create_node('create_demo')
        executor.add_node(node)
        recorder = Recorder(node, bag)
        recorder.describe()
        pilot = Pilot(node, executor, check)
        try:
            yield pilot
        finally:
            # The wheels come first: the robot stops when its node ends.
            children.end()
            recorder.close()


def record(steps: Sequence[TourStep], bag: Path, stop: threading.Event) -> None:
    """Start a simulated robot and its node, and record the tour; GoalFailed, Stopped: cut."""
    children = Children()
    with ExitStack() as stack:
        port = f'{stack.enter_context(run_folder())}/create'
        # In a domain that was given, another robot may obey the tour, or ours its driver.
        os.environ.pop('ROS_DOMAIN_ID', None)
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
        domain = stack.enter_context(run_domain())
        say(f'to look at the robot from another shell: export ROS_DOMAIN_ID={domain}')
        stack.callback(children.end)
        children.start('create_sim', '--link', port, '--world', WORLD,
                       '--odometry', 'carry')
        children.start('create_node', '--ros-args', '-p', f'port:={port}')
        tour(steps, stack.enter_context(recording(bag, children, stop)))


def report(folder: Path) -> int:
    """Run `create_report`; return 0, or 2 when it fails."""
    say('the report is being made')
    page = folder / 'report.html'
    made = start('create_report', str(folder / BAG), '-o', str(page), stdout=subprocess.DEVNULL)
    if made.wait() != 0:
        return 2
    say(f'the bag is {folder / BAG}')
    say(f'look at {page}')
    return 0


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='create_demo', description='Drive a simulated Create through a three-minute tour, '
        'record everything to a bag, and make a report of it.')
    parser.add_argument('-o', dest='folder', type=Path, metavar='FOLDER',
                        default=Path(f'demo-{datetime.now():%Y%m%d-%H%M%S}'),
                        help='a new folder for bag and report (default: demo-DATE-TIME)')
    parser.add_argument('--short', action='store_true', help='a tune and a turn only')
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_demo`; 1: the tour failed, 2: no whole bag or no report could be made."""
    parser = _arguments()
    options = parser.parse_args(arguments)
    if options.folder.exists():
        parser.error(f'{options.folder} is there already')
    stop, code = threading.Event(), 0
    call_on_signal(stop.set)
    check_environment()
    options.folder.mkdir(parents=True)
    try:
        record(SHORT if options.short else TOUR, options.folder / BAG, stop)
    except GoalFailed as error:
        say(f'the tour ends here: {error}')
        code = 1
    except Stopped:
        say(f'stopped; what was recorded is {options.folder / BAG}')
        return INTERRUPTED
    except OSError as error:
        say(f'recording has ended: {error}')
        return 2
    except ModuleNotFoundError as error:
        say(missing((error.name or '').partition('.')[0]))
        return 2
    made = report(options.folder)
    return code or made  # of a tour that ends at once nothing may have been recorded
