# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What must happen with a frame before it is published: check, time stamp, odometry.

What else follows from a frame is worked out afterwards, in `machine`.
"""

from dataclasses import replace
from typing import NamedTuple

from .. import oi
from ..odometry import Estimate, Increment, Knowledge, Odometry
from .events import LinkCounts, Moved
from .frame_clock import FrameClock, LEAST_STEP
from .plausibility import JumpCheck, OddValues
from .script_speeds import Speeds
from .settings import Settings

LIFTED = int(oi.BumpsAndWheelDrops.WHEEL_DROP_LEFT | oi.BumpsAndWheelDrops.WHEEL_DROP_RIGHT)
"""A wheel that hangs does not move the robot, whatever it counts."""
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

    def __init__(
        self, settings: Settings, counts: LinkCounts, odometry: Odometry | None = None,
    ) -> None:
        robot = settings.robot
        self.odometry = odometry or Odometry(
            settings.geometry, window=settings.odometry_window, robot=robot)
        self.readings = oi.Readings()
        """The newest of every packet that has arrived so far."""
        self.clock = FrameClock() if robot is None else FrameClock(robot.frame_period)
        self._counts = counts
        self.odd = OddValues(counts)
        self._jumps = JumpCheck()
        self._reading_dropped = False
        """Whether a frame with distance and angle was dropped since the last one taken."""
        self._unseen = self._found_lost = 0.0
        self._held: Increment | None = None
        """A frame after a gap, with its reading: the next one tells how long the gap was. Until
        then the robot is taken to have driven on for a slot."""
        self._before = Increment(LEAST_STEP, right=0.0, left=0.0, driven=False)
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

    def restart(self) -> None:
        """Continue after frames were missed."""
        self.clock.restart()
        self._jumps.restart()
        self._held, self._found_lost = None, 0.0
        self.odometry.interrupted()

    def take(self, frame: oi.Frame, baud: int, now: float) -> Taken | None:
        """Take a verified frame in; None where `OddValues` drops it."""
        stamp, dt = self.clock.stamp(now, frame.packets.wire_time(baud))
        self._unseen += dt
        self._found_lost += self.clock.found_lost
        readings = self.odd.corrected(frame.readings)
        if readings is None:
            self._reading_dropped |= 'distance' in frame.packets.names
            return None
        dt, self._unseen = self._unseen, 0.0
        self._counts.frames += 1
        self.readings = self.readings.updated(readings)
        return Taken(readings, stamp, dt)

    def moved(self, taken: Taken, speeds: Speeds | None) -> Moved:
        """Report how the robot moved; `speeds` are the requested ones, None where not known."""
        readings = taken.readings
        asked = readings.has('distance', 'angle')
        if asked and not self._jumps.possible(readings, taken.stamp, self.clock.absent):
            self._counts.impossible_jumps += 1
            asked = False
        estimate = self._estimate(taken, speeds, asked=asked)
        return Moved(taken.stamp, self.readings, estimate)

    def _estimate(self, taken: Taken, speeds: Speeds | None, *, asked: bool) -> Estimate:
        readings = taken.readings
        right, left = speeds or STANDING
        drops, mode = wheel_drops_and_mode(readings)
        increment = Increment(
            dt=taken.dt, right=right, left=left,
            driven=mode in DRIVEN and speeds is not None, lifted=bool(drops & LIFTED),
            lost=(self.clock.gap or self._reading_dropped
                  or readings.has('distance') and not asked),
            distance=readings.distance if asked else None,
            angle=readings.angle if asked else None)
        lost, self._found_lost, self._due = self._found_lost, 0.0, False
        self._reading_dropped = False
        if self._held is not None:
            self.odometry.update(
                self._held._replace(dt=max(lost, LEAST_STEP), lost=lost > 0))
            self._due = self.odometry.reading_due
            self._held, lost = None, 0.0
        before, self._before = self._before, increment
        if self.clock.undecided:
            self._held = increment
            return self.odometry.update(increment._replace(
                right=before.right, left=before.left, lost=False, distance=None, angle=None))
        return self.odometry.update(
            increment._replace(dt=increment.dt + lost) if lost else increment)
