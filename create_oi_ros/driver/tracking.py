# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What must happen with a frame before it is published: check, time stamp, odometry.

What cannot be true is found here: values, jumps, and an angle that stays while the robot turns.
What else follows from a frame is worked out afterwards, in `machine`.
"""

from collections import Counter
from dataclasses import replace
from math import degrees, inf, isnan, nan
from typing import NamedTuple

from .. import oi
from ..odometry import Estimate, GyroOdometry, GyroState, Increment, Knowledge, Odometry
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
from .frame_clock import FrameClock, MIN_STEP
from .script import Speeds
from .stream import requested_speeds

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
STUCK_ANGLE, STUCK_READINGS = 360.0, 3
"""Degrees of requested turning, and readings on the way, after which the angle should have
changed: a long turn may be in a reading that was lost."""
ANGLE_STUCK = (
    'the angle does not change though the robot was told to turn: are the wheels blocked, or does '
    'odometry_window: 0 hide slow turns? Some firmware before 3.4.1 is reported to send a '
    'constant 0')


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


class JumpCheck:
    """Refuses a distance or an angle that nothing could have made in the time."""

    def __init__(self) -> None:
        self._since: float | None = None

    def restart(self) -> None:
        """Forget when the last reading was: the next spans an unknown time."""
        self._since = None

    def possible(self, readings: oi.Readings, stamp: float, gap: float = 0.0) -> bool:
        """Tell whether a reading can be true that left at `stamp`, or so many seconds later."""
        elapsed = inf if self._since is None else stamp + gap - self._since
        self._since = stamp
        return (abs(readings.distance) <= MAX_SPEED * elapsed * MM_PER_M + DISTANCE_SLACK
                and abs(readings.angle) <= MAX_TURN_RATE * elapsed + ANGLE_SLACK)


class TurnCheck:
    """Notices an angle that never changes though the robot is told to turn."""

    def __init__(self, wheel_separation: float) -> None:
        """Take the wheel separation in metres."""
        self._separation = wheel_separation
        self._requested = 0.0
        self._readings = 0
        self.stuck = False
        """Whether the angle should have changed long ago."""

    def observe(self, readings: oi.Readings, dt: float, *, drives: bool) -> bool:
        """
        Take a frame in, `dt` seconds after the last; True when it has just become stuck.

        `drives`: whether the robot follows the speeds that are asked of it.
        """
        right, left = requested_speeds(readings)
        if right == left and not self._requested:
            return False  # as in most frames
        if readings.number('angle', 0):
            self._requested, self._readings, self.stuck = 0.0, 0, False
            return False
        if drives and None not in (right, left):
            self._requested += degrees((right - left) / MM_PER_M / self._separation) * dt
        if not readings.has('angle'):
            return False
        self._readings += 1
        before = self.stuck
        self.stuck = self._readings >= STUCK_READINGS and abs(self._requested) > STUCK_ANGLE
        return self.stuck and not before


LIFTED = int(oi.BumpsAndWheelDrops.WHEEL_DROP_LEFT | oi.BumpsAndWheelDrops.WHEEL_DROP_RIGHT)
"""A wheel that hangs does not move the robot, whatever it counts."""
BUMPED = int(oi.BumpsAndWheelDrops.BUMP_LEFT | oi.BumpsAndWheelDrops.BUMP_RIGHT)
STANDING: Speeds = (0.0, 0.0)
DRIVEN = frozenset(map(int, oi.DriveDirect.modes))
"""Modes in which the wheels obey, as plain numbers: Python hashes a member by its name."""
wheel_drops_and_mode = oi.Readings.numbers('bumps_and_wheel_drops', 'oi_mode')


class Taken(NamedTuple):
    """A frame that was believed."""

    readings: oi.Readings
    """What this frame brought; None is what cannot be true."""
    stamp: float
    """When it left the robot."""
    dt: float
    """The robot's seconds since the last one that was taken."""


class Tracking:
    """Follows the robot from frame to frame."""

    def __init__(self, core: Core, odometry: Odometry | None = None) -> None:
        settings, robot = core.settings, core.settings.robot
        wheels = odometry or Odometry(
            settings.geometry, window=settings.odometry_window, robot=robot)
        self._gyro = None if settings.gyro is None else GyroOdometry(
            wheels, settings.gyro, None if robot is None else robot.gyro)
        self.odometry = self._gyro or wheels
        self.clock = FrameClock() if robot is None else FrameClock(robot.frame_period)
        self._core = core
        self.odd = OddValues(core)
        self._jumps = JumpCheck()
        self._reading_dropped = False
        """Whether a frame with distance and angle was dropped since the last one taken."""
        self._unseen = self._found_lost = 0.0
        self._held: Increment | None = None
        """A frame after a gap, with its reading: the next one tells how long the gap was. Until
        then the robot is taken to have driven on for a slot."""
        self._before = Increment(MIN_STEP, right=0.0, left=0.0, driven=False)
        self._due = False
        """Whether the odometry asked for a reading after the held frame."""

    @property
    def reading_due(self) -> bool:
        """Whether the robot should be asked for distance and angle in its next frame."""
        return self._due or self.odometry.reading_due

    @property
    def robot(self) -> Knowledge | None:
        """What was learned of the robot; None before anything was."""
        known = self.odometry.knowledge
        return None if known is None else replace(known, frame_period=self.clock.known_period)

    @property
    def gyro(self) -> GyroState | None:
        """What is thought of the gyro; None: there is none."""
        return None if self._gyro is None else self._gyro.state

    def restart(self) -> None:
        """Continue after frames were missed."""
        self.clock.restart()
        self._jumps.restart()
        self._held, self._found_lost = None, 0.0
        self.odometry.interrupted()

    def take(self, frame: oi.Frame, baud: int, now: float) -> Taken | None:
        """Take a verified frame in; None where `OddValues` drops it."""
        stamp, dt = self.clock.stamp(now, frame.packets.budget(baud).seconds)
        self._unseen += dt
        self._found_lost += self.clock.found_lost
        readings = self.odd.corrected(frame.readings)
        if readings is None:
            self._reading_dropped |= 'distance' in frame.packets.names
            return None
        dt, self._unseen = self._unseen, 0.0
        self._core.counts.frames += 1
        self._core.readings = self._core.readings.updated(readings)
        return Taken(readings, stamp, dt)

    def moved(self, taken: Taken, speeds: Speeds | None) -> Moved:
        """Report how the robot moved; `speeds` are the requested ones, None where not known."""
        return Moved(taken.stamp, self._core.readings, self._estimate(taken, speeds))

    def _estimate(self, taken: Taken, speeds: Speeds | None) -> Estimate:
        readings, has_distance = taken.readings, taken.readings.has('distance')
        measured = has_distance and readings.has('angle')
        if measured and not self._jumps.possible(readings, taken.stamp, self.clock.absent):
            self._core.counts.impossible_jumps += 1
            measured = False
        right, left = speeds or STANDING
        drops, mode = wheel_drops_and_mode(readings)
        increment = Increment(
            dt=taken.dt, right=right, left=left,
            driven=mode in DRIVEN and speeds is not None, lifted=bool(drops & LIFTED),
            lost=self.clock.gap or self._reading_dropped or has_distance and not measured,
            distance=readings.distance if measured else None,
            angle=readings.angle if measured else None)
        if self._gyro is not None:
            volts = readings.analog_volts if readings.has('analog_signal') else nan
            increment = increment._replace(
                analog=None if isnan(volts) else volts, bumped=bool(drops & BUMPED))
        lost, self._found_lost = self._found_lost, 0.0
        self._reading_dropped = self._due = False
        if self._held is not None:
            self.odometry.update(self._held._replace(dt=max(lost, MIN_STEP), lost=lost > 0))
            self._due = self.odometry.reading_due
            self._held, lost = None, 0.0
        before, self._before = self._before, increment
        if self.clock.undecided:
            self._held = increment
            return self.odometry.update(increment._replace(
                right=before.right, left=before.left, lost=False, distance=None, angle=None))
        return self.odometry.update(
            increment._replace(dt=increment.dt + lost) if lost else increment)
