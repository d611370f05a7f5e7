# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_demo`: a simulated robot drives a tour, which is recorded to a bag and reported on.

A pilot drives by goals, services and velocities, and waits for what the robot reports. The tour
leads through the world `apartment`, where the robot starts at (0, 0).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, ExitStack
from datetime import datetime
from math import dist, pi, remainder, tau
import os
from pathlib import Path
import subprocess
import threading
import time
from typing import Any

from create_oi_msgs.msg import Bumper, Mode
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, Pose, PoseStamped, Twist, Vector3
from nav_msgs.msg import Odometry
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from ..ros.bags import Recorder
from ..ros.goal_client import GoalClient, GoalFailed
from ..ros.messages import yaw_of
from ..ros.process import call_on_signal, Children, ros_executor, start
from ..ros.programs import check_environment, INTERRUPTED
from ..ros.robot_state import RobotState
from ..ros.simulated_run import run_domain, run_folder
from ..ros.topics import CMD_VEL

PERIOD = 0.05
"""Seconds between two commands."""
STANDING = 0.01
"""m/s; a slower robot stands."""


class TourError(GoalFailed):
    """Something that the tour waits for did not happen; the message says what."""


class Stopped(Exception):
    """A signal has ended the tour."""


class Pilot(GoalClient):
    """Drives the robot; each method returns when its motion is complete."""

    def __init__(
        self, node: Node, executor: SingleThreadedExecutor, check: Callable[[], None],
    ) -> None:
        """`check` is called while waiting, and may raise to end the tour."""
        super().__init__()
        self.node, self._executor, self._check = node, executor, check
        self._velocity = node.create_publisher(Twist, CMD_VEL, 1)
        self._commanded: Twist | None = None
        self._next = 0.0
        self.state = RobotState()
        self.state.listen(node, Odometry, Bumper, Mode, DiagnosticArray)

    @property
    def odom(self) -> Odometry | None:
        """The newest pose and speed; None before the first."""
        return self.state.newest(Odometry)

    @property
    def mode(self) -> int:
        """The mode, as the message Mode has it."""
        mode = self.state.newest(Mode)
        return Mode.UNKNOWN if mode is None else int(mode.mode)

    @property
    def bumped(self) -> bool:
        """Whether the bumper is pressed."""
        bumper = self.state.newest(Bumper)
        return bumper is not None and bool(bumper.left or bumper.right)

    @property
    def warnings(self) -> list[str]:
        """What the diagnostics warn of."""
        diagnostics = self.state.newest(DiagnosticArray) or DiagnosticArray()
        return [each.message for each in diagnostics.status if each.level != DiagnosticStatus.OK]

    @property
    def place(self) -> tuple[float, float]:
        """Position by the odometry, metres."""
        if self.odom is None:
            return 0.0, 0.0
        return self.odom.pose.pose.position.x, self.odom.pose.pose.position.y

    @property
    def yaw(self) -> float:
        """Heading by the odometry, rad."""
        if self.odom is None:
            return 0.0
        return yaw_of(self.odom.pose.pose.orientation)

    @property
    def standing(self) -> bool:
        """Whether the robot stands still."""
        twist = self.odom.twist.twist if self.odom else Twist()
        return bool(abs(twist.linear.x) < STANDING and abs(twist.angular.z) < 5 * STANDING)

    def until(self, happened: Callable[[], Any], what: str, seconds: float = 10.0) -> None:
        """Wait for a condition; TourError: it did not come in time."""
        deadline = time.monotonic() + seconds
        while not happened():
            if time.monotonic() > deadline:
                self.release()
                raise TourError(f'{what} did not happen within {seconds:.0f} s')
            self._spin()

    def _spin(self) -> None:
        """Receive, and send the velocity that is set when it is time."""
        self._check()
        self._executor.spin_once(timeout_sec=PERIOD / 2)
        if self._commanded is not None and time.monotonic() >= self._next:
            self._next = time.monotonic() + PERIOD
            self._velocity.publish(self._commanded)

    def command(self, speed: float, turn: float) -> None:
        """Set the velocity to send from now on, m/s and rad/s."""
        self._commanded = Twist(linear=Vector3(x=speed), angular=Vector3(z=turn))

    def release(self) -> None:
        """Send a zero velocity, then no more commands."""
        self._velocity.publish(Twist())
        self._commanded = None

    def start(self, name: str, **goal: Any) -> None:
        """Send a goal instead of velocities, which would take over."""
        self._commanded = None
        super().start(name, **goal)

    def turn_to(self, yaw: float) -> None:
        """Turn in place to a heading, the short way."""
        self.do('rotate_angle', angle=remainder(yaw - self.yaw, tau))

    def go_to(self, x: float, y: float) -> None:
        """Turn towards a point and drive there; GoalFailed: an obstacle is in the way."""
        place = Pose(position=Point(x=x, y=y))
        self.do('navigate_to_position', goal_pose=PoseStamped(pose=place))


# The tour.

WORLD = 'apartment'
GREEN, ORANGE, RED = 0, 96, 255
"""Colours of the power LED."""
HELLO, GOODBYE = 'C5:0.2 E5:0.2 G5:0.2 C6:0.4', 'G5:0.25 E5:0.25 C5:0.5'
"""Notes with their seconds."""
SIDE, RADII = 0.6, (0.15, 0.25, 0.35)
"""Side of the square, and radii of the circles, metres."""
WALL_AHEAD = (-0.1, -1.5)
"""A point in front of a wall of the living room; x is the robot's first heading."""
DOORS = ((0.4, -1.05), (2.85, -1.05), (2.85, -3.25))
"""The way to the hall, through two doors."""
EDGE_SPEED = 0.05
"""m/s towards the stairs: from faster the robot comes to rest with its caster over the edge, and
cannot go back to Safe."""
BACK_SPEED = 0.1
"""m/s away from them."""
EDGE_TIMEOUT = 40.0
"""Seconds in which it reaches them."""


def hello(pilot: Pilot) -> None:
    """Wait for the robot, and play a tune."""
    pilot.until(lambda: pilot.odom is not None and pilot.mode == Mode.SAFE,
                'the robot answers and is in Safe', 30.0)
    pilot.call('set_leds', play=True, power_color=GREEN, power_intensity=255)
    pilot.do('audio_note_sequence', notes=HELLO)


def square(pilot: Pilot) -> None:
    """Drive a square to the right, and turn back to the first heading."""
    for x, y in ((SIDE, 0.0), (SIDE, -SIDE), (0.0, -SIDE), (0.0, 0.0)):
        pilot.go_to(x, y)
    pilot.turn_to(0.0)


def circles(pilot: Pilot) -> None:
    """Drive circles to the right, each larger than the one before."""
    pilot.call('set_leds', advance=True, power_color=ORANGE, power_intensity=255)
    for radius in RADII:
        pilot.do('drive_arc', angle=-tau, radius=radius, translate_direction=1)


def bump_and_turn(pilot: Pilot) -> None:
    """Bump into two walls, backing off each time."""
    pilot.go_to(*WALL_AHEAD)
    for heading in (-pi / 2, 0.0):
        pilot.turn_to(heading)
        pilot.command(0.2, 0.0)
        pilot.until(lambda: pilot.bumped, 'a bump into a wall', 20.0)
        pilot.do('drive_distance', distance=-0.2)


def to_the_hall(pilot: Pilot) -> None:
    """Drive through two doors."""
    pilot.call('set_leds', play=True, advance=True, power_color=GREEN,
               power_intensity=128)
    for x, y in DOORS:
        pilot.go_to(x, y)
    pilot.turn_to(0.0)


def cliff(pilot: Pilot) -> None:
    """Drive to the stairs, where the robot stops by itself in Passive; come back."""
    pilot.command(EDGE_SPEED, 0.0)
    pilot.until(lambda: pilot.mode == Mode.PASSIVE, 'a cliff drops the robot to Passive',
                EDGE_TIMEOUT)
    pilot.release()
    pilot.until(lambda: pilot.standing, 'the robot stands at the edge')
    pilot.until(lambda: any('PASSIVE instead of SAFE' in each for each in pilot.warnings),
                'the diagnostics warn of Passive')
    # The robot rolls on a little: where a wheel hangs over the edge, it refuses Safe, and the
    # driver refuses goals, but not velocities.
    pilot.call('set_mode', mode=Mode.FULL)
    edge = pilot.place
    pilot.command(-BACK_SPEED, 0.0)
    pilot.until(lambda: dist(edge, pilot.place) > 0.4, 'the robot backs off', EDGE_TIMEOUT)
    pilot.release()
    pilot.until(lambda: pilot.standing, 'the robot stands')
    pilot.call('set_mode', mode=Mode.SAFE)
    pilot.until(lambda: pilot.mode == Mode.SAFE, 'the robot is in Safe')


def goodbye(pilot: Pilot) -> None:
    """Turn round, play another tune, and release the wheels."""
    pilot.turn_to(pi)
    pilot.call('set_leds', power_color=RED, power_intensity=60)
    pilot.do('audio_note_sequence', notes=GOODBYE)
    pilot.release()


TourStep = tuple[str, Callable[[Pilot], None]]
"""Its title, and what is done."""
TOUR: Sequence[TourStep] = (
    ('LEDs and a tune', hello), ('a square', square), ('three circles', circles),
    ('bump and turn, twice', bump_and_turn), ('through two doors to the hall', to_the_hall),
    ('the stairs: a cliff, Passive, back off in Full, Safe', cliff), ('another tune', goodbye))
SHORT: Sequence[TourStep] = (
    ('LEDs and a tune', hello), ('a turn', lambda pilot: pilot.turn_to(pi / 2)),
    ('another tune', goodbye))


# The program.

BAG = 'create_demo'
SIGN_INTERVAL = 8.0
"""Seconds after which a line says where the robot is: a step takes up to half a minute."""


def say(text: str) -> None:
    """Print a line and flush it."""
    print(f'create_demo: {text}', flush=True)


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
        pilot = stack.enter_context(recording(bag, children, stop))
        began = time.monotonic()
        for number, (title, do) in enumerate(steps, 1):
            say(f'{time.monotonic() - began:5.1f} s  {number} of {len(steps)}: {title}')
            do(pilot)


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
    made = report(options.folder)
    return code or made  # of a tour that ends at once nothing may have been recorded
