# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What must happen with a frame before it is published: check, time stamp, odometry.

What cannot be true is found here: values and jumps. What else follows from a frame is worked out
afterwards, in `machine`.
"""

from collections import Counter
from dataclasses import replace
from math import inf, nan

from .. import oi
from ..odometry import Increment, Knowledge, Odometry
from ..odometry.estimate import TAUGHT
from ..oi.readings import ALLOWED
from ..robot import (
    BATTERY_DEGREES,
    BATTERY_MILLIAMPS,
    BATTERY_MILLIVOLTS,
    MM_PER_M,
    MOST_CAPACITY,
    MOST_CHARGE,
)
from .core import Core
from .events import Moved, Severity
from .frame_clock import FrameClock
from .motion import BUMPS
from .script import ScriptControl

BATTERY = {
    'voltage': BATTERY_MILLIVOLTS, 'current': BATTERY_MILLIAMPS,
    'battery_temperature': BATTERY_DEGREES,
    'battery_charge': range(int(MOST_CHARGE * MOST_CAPACITY) + 1),
    'battery_capacity': range(MOST_CAPACITY + 1)}
"""What the hardware can have, where the manual allows all numbers."""
POSSIBLE = ALLOWED | BATTERY
ODD_FRAMES = 3
"""Odd frames in a row that are no accident: this robot sends such values."""

MAX_SPEED, MAX_TURN_RATE = 1.0, 450.0
"""m/s and deg/s: twice what the wheels can do, for a robot that is pushed."""
DISTANCE_SLACK, ANGLE_SLACK = 50, 20
"""mm and degrees that are allowed beyond that, for whole units and late frames."""


class OddValues:
    """
    Decides what becomes of values that no Create should have.

    One frame with a value that the manual rules out is dropped: damage can have a correct
    checksum. In the third frame in a row it is no damage. From then on the robot may have
    anything in that packet: bits without a meaning are cleared, numbers and codes become None.
    """

    def __init__(self, core: Core) -> None:
        self._core = core
        self.newest: dict[str, int] = {}
        """Odd values in the newest frames that had their packets, by field."""
        self._running: Counter[str] = Counter()
        """Frames in a row in which a field was odd."""
        self._known: set[str] = set()
        self._dropped = 0
        """Frames in a row that were dropped."""

    def corrected(self, readings: oi.Readings) -> oi.Readings | None:
        """Return a verified frame's readings without what cannot be; None: drop the frame."""
        odd = readings.implausible(POSSIBLE)
        if not odd and not self._running:
            return readings  # as in most frames
        for name in [name for name in self._running if readings.has(name) and name not in odd]:
            del self._running[name]
            self.newest.pop(name, None)
        self._running.update(odd)
        ruled_out = set(readings.implausible()) - self._known
        if (self._dropped < ODD_FRAMES - 1
                and any(self._running[name] < ODD_FRAMES for name in ruled_out)):
            self._dropped += 1
            self._core.counts.implausible_frames += 1
            return None
        self._dropped = 0
        self._core.counts.odd_values += len(odd)
        for name in odd:
            self.newest[name] = readings.number(name, 0)
            certain = name in ruled_out or self._running[name] >= ODD_FRAMES
            if certain and name not in self._known:
                self._known.add(name)
                self._core.notice(
                    Severity.WARNING, _unlike_the_manual(name, self.newest[name]))
        return readings.corrected(odd)


def _unlike_the_manual(name: str, value: int) -> str:
    """Tell the user of a packet with a value that no Create should have."""
    number, title, wire = oi.PACKETS[oi.NUMBERS[name]]
    allowed = wire.describe()
    if name in BATTERY:
        allowed = f'{BATTERY[name][0]} to {BATTERY[name][-1]} {wire.unit}'
    meant = wire.without_spare_bits(value)
    return (f'the robot sends {title} (packet {number}) = {value}, which no Create should have '
            f'(allowed: {allowed}): the driver takes it as '
            f'{"not known" if meant is None else meant} and goes on; please report it')


LIFTED = int(oi.BumpsAndWheelDrops.WHEEL_DROP_LEFT | oi.BumpsAndWheelDrops.WHEEL_DROP_RIGHT)
"""A wheel that hangs does not move the robot, whatever it counts."""


class Tracking:
    """Follows the robot from frame to frame."""

    def __init__(
        self, core: Core, scripts: ScriptControl, odometry: Odometry | None = None,
    ) -> None:
        settings, robot = core.settings, core.settings.robot
        self.odometry = odometry or Odometry(
            settings.geometry, window=settings.odometry_window, robot=robot, gyro=settings.gyro)
        self.clock = FrameClock() if robot is None else FrameClock(robot.frame_period)
        self._core = core
        self._scripts = scripts
        self._reported = None if robot is None else robot.likeliest
        """What the user was told of the robot, or has told the driver."""
        self.odd = OddValues(core)
        self._read_at = -inf
        """When the newest distance and angle left the robot, s; -inf: frames were missed since."""
        self._reading_dropped = False
        """Whether a frame with distance and angle was dropped since the last one taken."""
        self._unseen = 0.0
        """Seconds of the frames that were dropped since then."""
        self._missed = False
        """Whether frames were missed since the newest one."""

    @property
    def robot(self) -> Knowledge | None:
        """What was learned of the robot; None before anything was."""
        known = self.odometry.knowledge
        return None if known is None else replace(known, frame_period=self.clock.known_period)

    def report_robot(self) -> None:
        """Report a robot that has become known, or that is another than was thought."""
        robot, before = self.robot, self._reported
        if (robot is None or not robot.certain or robot.readings < TAUGHT
                or robot.likeliest == before):
            return
        self._reported = robot.likeliest
        known = 'the odometry knows this robot now' if before is None else (
            'this robot is another than the odometry thought; it has learned')
        self._core.notice(Severity.INFO, f'{known}: /diagnostics has its numbers')

    def restart(self) -> None:
        """Continue after frames were missed."""
        self.clock.restart()
        self._read_at = -inf
        self._missed = True

    def take(self, frame: oi.Frame, baud: int, now: float) -> Moved | None:
        """Take a verified frame in; return how the robot moved, None where it is dropped."""
        core, garbage, before = self._core, self._core.counts.garbage_bytes, self.clock.newest
        stamp, dt = self.clock.stamp(
            now, frame.packets.budget(baud).seconds, lost=garbage != core.garbage_before)
        core.garbage_before = garbage
        if self._missed:
            self.odometry.interrupted(0.0 if before == -inf else stamp - before)
            self._missed = False
        self._unseen += dt
        readings = self.odd.corrected(frame.readings)
        if readings is None:
            self._reading_dropped |= 'distance' in frame.packets.names
            return None
        dt, self._unseen = self._unseen, 0.0
        core.counts.frames += 1
        core.readings = core.readings.updated(readings)
        increment = self._increment(readings, stamp, dt)
        estimate = self.odometry.update(increment)
        return Moved(stamp, core.readings, estimate, dt, readings, increment.lost)

    def _increment(self, readings: oi.Readings, stamp: float, dt: float) -> Increment:
        """Return what a frame tells the odometry."""
        has_distance = readings.has('distance')
        measured = has_distance and readings.has('angle')
        if measured and not self._possible(readings, stamp) and not self.clock.gap:
            self._core.counts.impossible_jumps += 1
            measured = False
        obeys = readings.oi_mode in oi.DriveDirect.modes
        speeds = self._scripts.speeds(readings) if obeys else None
        right, left = speeds or (0.0, 0.0)
        drops = readings.number('bumps_and_wheel_drops', 0)
        increment = Increment(
            dt=dt, right=right, left=left,
            by_itself=speeds is None and self._core.state.robot_moves,
            lifted=bool(drops & LIFTED),
            lost=(self.clock.gap and self.odometry.reading_asked or self._reading_dropped
                  or has_distance and not measured),
            distance=readings.distance if measured else None,
            angle=readings.angle if measured else None,
            analog=readings.analog_volts if readings.has('analog_signal') else nan,
            bumped=bool(drops & BUMPS))
        self._reading_dropped = False
        return increment

    def _possible(self, readings: oi.Readings, stamp: float) -> bool:
        """Tell whether anything can have made a distance and an angle in the time."""
        elapsed, self._read_at = stamp - self._read_at, stamp
        return (abs(readings.distance) <= MAX_SPEED * elapsed * MM_PER_M + DISTANCE_SLACK
                and abs(readings.angle) <= MAX_TURN_RATE * elapsed + ANGLE_SLACK)
