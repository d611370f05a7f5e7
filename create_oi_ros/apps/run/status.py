# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The status line of `create_run`: what is known of the robot, and how a terminal shows it."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import degrees, isnan
import os
import re
import sys
from typing import Any

from create_oi_msgs.msg import Bumper, Mode
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from ...ros.diagnostics import LINK
from ...ros.messages import mode_name, yaw_of
from ...ros.robot_state import RobotState

WIDTH = 80
"""Columns of the line at most."""
POSE_TEXTS = 2
"""Parts of the motion that are the pose."""
SIDES = 'left', 'right'
"""Of the bumper."""
CLEAR = '\r\x1b[K'
"""Go to the begin of the line, and clear it."""
LOG_FORMAT = 'RCUTILS_CONSOLE_OUTPUT_FORMAT'
USUAL_FORMAT = '[{severity}] [{time}] [{name}]: {message}'


class RobotStatus(RobotState):
    """Collects what the driver publishes, and puts it into one line."""

    def __init__(self) -> None:
        super().__init__()
        self._frames = 0
        self._pressed: set[str] = set()
        """Sides of the bumper that were pressed since the last line."""
        self._troubles: list[str] = []
        self._no_robot = ''
        """Why no robot answers, as far as the driver knows."""

    def take(self, message: Any) -> None:
        """Take a message; count frames, and remember a short touch until the next line."""
        super().take(message)
        if isinstance(message, Odometry):
            self._frames += 1
        self._pressed |= self._now_pressed()
        if isinstance(message, DiagnosticArray):
            self._take_diagnostics(message)

    def _now_pressed(self) -> set[str]:
        bumper = self.newest(Bumper)
        return {side for side in SIDES if bumper is not None and getattr(bumper, side)}

    def _take_diagnostics(self, diagnostics: DiagnosticArray) -> None:
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
        motion, mode = self._motion(), self.newest(Mode)
        robot = mode is None or mode.mode != Mode.UNKNOWN
        pose = POSE_TEXTS if robot else 0
        said = (*motion[:pose], *self._remarks())
        line = '  '.join((f'{self._frames:2d} frames/s', self._mode_text(), *said))
        if len(line) > WIDTH:
            line = '  '.join((self._mode_text().rstrip(), *said))
        if len(line) > WIDTH:
            line = f'{line[:WIDTH - 3]}...'
        for text in motion[pose:]:
            if len(line) + 2 + len(text) > WIDTH:
                break
            line += f'  {text}'
        self._frames, self._pressed = 0, self._now_pressed()
        return line.rstrip()

    def _mode_text(self) -> str:
        mode = self.newest(Mode)
        return 'no node yet' if mode is None else f'{mode_name(mode.mode, mode.reason):7s}'

    def _remarks(self) -> list[str]:
        """Return what is unusual, the most important first."""
        sides, mode = ' and '.join(sorted(self._pressed)), self.newest(Mode)
        remarks = [f'BUMP {sides}'] if sides else []
        if mode is not None and mode.reason:
            unknown = mode.mode == Mode.UNKNOWN
            remarks.append((self._no_robot if unknown else '') or mode.reason)
        # No robot answers: all else follows from that.
        elif mode is not None:
            remarks += map(gist, self._troubles)
        return remarks

    def _motion(self) -> list[str]:
        odom = self.newest(Odometry)
        if odom is None:
            return []
        pose, twist = odom.pose.pose, odom.twist.twist
        return [f'x {pose.position.x:+.2f} y {pose.position.y:+.2f} m',
                f'{degrees(yaw_of(pose.orientation)):+4.0f} deg', self._battery_text(),
                f'{twist.linear.x:+.2f} m/s', f'{twist.angular.z:+.2f} rad/s']

    def _battery_text(self) -> str:
        battery = self.newest(BatteryState)
        return '' if battery is None or isnan(battery.percentage) else f'{battery.percentage:.0%}'


def gist(message: str) -> str:
    """Return a long message without its advice: the first clause, and what brackets add to it."""
    if len(message) <= WIDTH // 2:
        return message
    added = re.search(r' \([^()]*\)$', message)
    return message.partition(', ')[0] + (added[0] if added else '')


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
