# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The status line of `create_run`: what is known of the robot, and how a terminal shows it."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import degrees, isnan
import os
import re
import sys

from create_oi_msgs.msg import Bumper, Mode
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from ...ros.diagnostics import LINK
from ...ros.messages import mode_name, yaw_of

WIDTH = 80
"""Columns of the line at most."""
POSE_TEXTS = 2
"""Parts of the motion that are the pose."""
CLEAR = '\r\x1b[K'
"""Go to the begin of the line, and clear it."""
LOG_FORMAT = 'RCUTILS_CONSOLE_OUTPUT_FORMAT'
USUAL_FORMAT = '[{severity}] [{time}] [{name}]: {message}'


class RobotStatus:
    """Collects what the driver publishes, and puts it into one line."""

    def __init__(self) -> None:
        self._frames = 0
        self._odom: Odometry | None = None
        self._mode: Mode | None = None
        self._battery: BatteryState | None = None
        self._pressed: dict[str, bool] = {'left': False, 'right': False}
        """Sides of the bumper that were pressed since the last line."""
        self._now_pressed = dict(self._pressed)
        self._troubles: list[str] = []
        self._no_robot = ''
        """Why no robot answers, as far as the driver knows."""

    def on_odom(self, odom: Odometry) -> None:
        """Take a pose; one comes with each frame of the robot."""
        self._odom = odom
        self._frames += 1

    def on_mode(self, mode: Mode) -> None:
        """Take the robot's mode."""
        self._mode = mode

    def on_battery(self, battery: BatteryState) -> None:
        """Take the state of the battery."""
        self._battery = battery

    def on_bumper(self, bumper: Bumper) -> None:
        """Take the bumper, and remember a short touch until the next line."""
        self._now_pressed = {'left': bumper.left, 'right': bumper.right}
        self._pressed = {side: was or self._now_pressed[side]
                         for side, was in self._pressed.items()}

    def on_diagnostics(self, diagnostics: DiagnosticArray) -> None:
        """Take what the driver complains about: a script, a damaged line, the battery."""
        for status in diagnostics.status:
            if status.name.endswith(f': {LINK}'):
                port = next((each.value for each in status.values if each.key == 'port'), '')
                # A port may have a long name, and nobody has two here.
                said = status.message.replace(port, 'port', 1) if port else status.message
                self._no_robot = said if status.level == DiagnosticStatus.ERROR else ''
        # The mode says its own reason; safety repeats the bumper.
        self._troubles = [
            status.message for about in ('driver', LINK, 'battery')
            for status in diagnostics.status
            if status.name.endswith(f': {about}') and status.level != DiagnosticStatus.OK]

    def line(self) -> str:
        """Return the line, and begin the next second; the pose of a robot is always in it."""
        motion, robot = self._motion(), self._mode is None or self._mode.mode != Mode.UNKNOWN
        pose = POSE_TEXTS if robot else 0
        said = (*motion[:pose], *self._remarks())
        line = '  '.join((f'{self._frames:2d} frames/s', self._mode_text(), *said))
        if len(line) > WIDTH:
            line = shortened('  '.join((self._mode_text().rstrip(), *said)))
        for text in motion[pose:]:
            if len(line) + 2 + len(text) > WIDTH:
                break
            line += f'  {text}'
        self._frames, self._pressed = 0, dict(self._now_pressed)
        return line.rstrip()

    def _mode_text(self) -> str:
        if self._mode is None:
            return 'no node yet'
        return f'{mode_name(self._mode.mode, self._mode.reason):7s}'

    def _remarks(self) -> list[str]:
        """Return what is unusual, the most important first."""
        sides = ' and '.join(side for side, pressed in self._pressed.items() if pressed)
        remarks = [f'BUMP {sides}'] if sides else []
        if self._mode is not None and self._mode.reason:
            unknown = self._mode.mode == Mode.UNKNOWN
            remarks.append((self._no_robot if unknown else '') or self._mode.reason)
        # No robot answers: all else follows from that.
        elif self._mode is not None:
            remarks += map(gist, self._troubles)
        return remarks

    def _motion(self) -> list[str]:
        if self._odom is None:
            return []
        pose, twist = self._odom.pose.pose, self._odom.twist.twist
        return [f'x {pose.position.x:+.2f} y {pose.position.y:+.2f} m',
                f'{degrees(yaw_of(pose.orientation)):+4.0f} deg', self._battery_text(),
                f'{twist.linear.x:+.2f} m/s', f'{twist.angular.z:+.2f} rad/s']

    def _battery_text(self) -> str:
        if self._battery is None or isnan(self._battery.percentage):
            return ''
        return f'{self._battery.percentage:.0%}'


def gist(message: str) -> str:
    """Return a long message without its advice: the first clause, and what brackets add to it."""
    if len(message) <= WIDTH // 2:
        return message
    added = re.search(r' \([^()]*\)$', message)
    return message.partition(', ')[0] + (added[0] if added else '')


def shortened(line: str) -> str:
    """Return a line cut to WIDTH."""
    return line if len(line) <= WIDTH else f'{line[:WIDTH - 3]}...'


def on_terminal() -> bool:
    """Return whether the line can be updated in place."""
    return sys.stdout.isatty() and os.environ.get('TERM', 'dumb') != 'dumb'


@contextmanager
def status_line() -> Iterator[None]:
    """Keep the log lines of children apart from a status line that is updated in place."""
    if not on_terminal():
        yield
        return
    # A log line begins by clearing the status line, which is shown again below it.
    os.environ[LOG_FORMAT] = CLEAR + os.environ.get(LOG_FORMAT, USUAL_FORMAT)
    try:
        yield
    finally:
        print(flush=True)


def show(line: str) -> None:
    """Show the line: in place on a terminal, as a line of its own elsewhere."""
    if on_terminal():
        columns = os.get_terminal_size(sys.stdout.fileno()).columns or WIDTH
        print(f'{CLEAR}{line[:columns - 1]}', end='\r', flush=True)
    else:
        print(line, flush=True)
