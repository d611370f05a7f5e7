# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Pose, twist and covariance from every frame and a reading now and then.

The bank of filters predicts the motion of each frame and corrects it by readings. This file
decides which readings the bank may learn from, and publishes a pose that moves as the wheels do:
corrections are blended in at a limited rate.
"""

from math import cos, exp, hypot, sin

import numpy as np

from .bank import Bank, Motion
from .estimate import Estimate, Geometry, Increment
from .hypotheses import Array, DEGREE, MM
from .knowledge import Knowledge
from .reading_plan import ReadingPlan

BLEND_TIME = 0.1
"""Seconds in which a correction is blended in."""
MAX_CORRECTION, MAX_TURN_CORRECTION = 0.067, 8 * DEGREE
"""The fastest that corrections are blended in, m/s and rad/s."""
FREE_CORRECTION, FREE_TURN_CORRECTION, FREE_TIME = 0.3, 3.0, 2.0
"""The same for so many seconds after wheels did not follow their requests: the robot moved so."""
GROWTH_EVERY = 5
"""Frames from one prediction of the covariance to the next."""
FLOOR = 1e-8
"""Least variance of a pose, m² and rad²."""
AS_BUILT = Geometry()


def blended(behind: tuple[float, float, float], dt: float, most: float = MAX_CORRECTION,
            most_turn: float = MAX_TURN_CORRECTION) -> tuple[float, float]:
    """Return the part of the place and the turn, rad, that are corrected in a frame."""
    x, y, yaw = behind
    off, part = hypot(x, y), 1 - exp(-dt / BLEND_TIME)
    share = min(part, most * dt / off) if off else 0.0
    return share, yaw * min(part, most_turn * dt / abs(yaw)) if yaw else 0.0


def moved_covariance(covariance: Array, way: tuple[float, float],
                     behind: tuple[float, float, float], far: float, turn: float,
                     ) -> tuple[float, ...]:
    """
    Return the covariance of a pose after a way whose variances are `far`, m², and `turn`, rad².

    The published pose is so far behind it.
    """
    (xx, xy, xa), (_, yy, ya), (_, _, aa) = covariance.tolist()
    (dx, dy), (x, y, yaw) = way, behind
    xx += dy * dy * aa - 2 * dy * xa + x * x + far + FLOOR
    xy += dx * xa - dy * ya - dx * dy * aa + x * y
    yy += dx * dx * aa + 2 * dx * ya + y * y + far + FLOOR
    xa, ya = xa - dy * aa + x * yaw, ya + dx * aa + y * yaw
    aa += turn + yaw * yaw + FLOOR
    return xx, xy, xa, xy, yy, ya, xa, ya, aa


class Odometry:
    """Turns increments into an estimate that never jumps."""

    def __init__(self, geometry: Geometry = AS_BUILT, *, window: float,
                 robot: Knowledge | None = None) -> None:
        """Ask for distance and angle every few `window` seconds; the robot is known or not."""
        self.geometry = geometry
        self.estimate = Estimate()
        self.bank = Bank(geometry, robot)
        self._plan = ReadingPlan(window)
        self._discard = True
        """Whether the next reading holds what came before."""
        self._lost = self._doubted = False
        """Whether the next reading may not be whole, or is to be taken as it is."""
        self._placed: tuple[float, ...] | None = None
        """Motion since the last reading when the pose was set; None: it was not."""
        self._contradicted = False
        """Whether the last reading said that wheels did not follow their requests."""
        self._free: tuple[float, float] | None = None
        """m/s and rad/s of wheels that do not follow their requests; None: they do."""
        self._seconds = self._far = 0.0
        self._moved = np.zeros(3)
        """Mean motion since the last reading: x, y, yaw in the frame of its start; its length and
        duration."""
        self._hurry = 0.0
        """Seconds for which corrections may be as fast as the robot."""
        self._behind = (0.0, 0.0, 0.0)
        """What of the corrections is not blended in yet."""
        self._base = np.zeros((3, 3))
        """Covariance of the pose at the last reading."""
        self._grown, self._twist_variance = (0.0, 0.0), self.estimate.twist_covariance
        self._frame = 0
        self._start = (0.0, 0.0, 0.0)
        """Mean pose at the last reading."""
        self._twist = (0.0, 0.0)
        """m/s and rad/s of the last frame, by the bank."""
        self._rolled = False
        """Whether the wheels changed their speeds in the last frame."""

    @property
    def reading_due(self) -> bool:
        """Whether the robot should be asked for distance and angle in its next frame."""
        return self._plan.due

    @property
    def heading(self) -> tuple[float, float]:
        """The yaw of the last reading, rad, and its variance."""
        return self._start[2], float(self._base[2, 2])

    @property
    def knowledge(self) -> Knowledge | None:
        """What was learned of the robot; None before anything was."""
        return self.bank.knowledge if self.bank.readings else None

    def reset(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> None:
        """Go on from a pose, m and rad; what was learned of the robot stays."""
        e = self.estimate
        self.estimate = Estimate(
            x=x, y=y, yaw=yaw, right_wheel=e.right_wheel, left_wheel=e.left_wheel)
        dx, dy, turn = self._moved.tolist()  # the window goes on
        heading = yaw - turn
        c, s = cos(heading), sin(heading)
        self._start = x - c * dx + s * dy, y - s * dx - c * dy, heading
        self.bank.reset(self._start)
        self._placed = dx, dy, turn
        self._behind = (0.0, 0.0, 0.0)
        self._base[:] = 0.0

    def recounted(self) -> None:
        """Learn nothing from the next reading: the robot has set its accumulators to zero."""
        self._discard = True

    def interrupted(self) -> None:
        """Go on from here after frames were missed: the next reading is taken as it is."""
        self._doubted = True

    def hurry(self) -> None:
        """Ask for the next reading soon."""
        self._plan.hurry()

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        dt = increment.dt
        request = (increment.right, increment.left) if increment.driven else (0.0, 0.0)
        far, turn = self._predicted(dt, request, increment.lifted)
        self._advance(far, turn)
        self._seconds += dt
        self._lost |= increment.lost or increment.lifted
        if increment.distance is not None and increment.angle is not None:
            self._read(increment.distance, increment.angle, increment.driven)
        self._plan.step(dt, request, self.bank,
                        free=self._contradicted or not increment.driven)
        return self._publish(dt, far, turn)

    def _predicted(self, dt: float, request: tuple[float, float], lifted: bool,
                   ) -> tuple[float, float]:
        """Return the mean distance and turn of a frame."""
        travel = self.bank.roll(dt, request, lifted=lifted)
        if travel is not None:
            far, turn = self.bank.motion(travel)
            self._twist = far / dt, turn / dt
        elif self._rolled:
            self._twist = self.bank.motion(self.bank.wheels.speed[:, 0])
        self._rolled = travel is not None
        if lifted:
            return 0.0, 0.0
        speed, rate = self._twist if self._free is None else self._free
        return speed * dt, rate * dt

    def _advance(self, far: float, turn: float) -> None:
        """Let the motion since the last reading go on along an arc."""
        if far or turn:
            middle = self._moved[2] + turn / 2
            self._moved += (far * cos(middle), far * sin(middle), turn)
            self._far += far

    def _read(self, distance: int, angle: int, driven: bool) -> None:
        """Let the bank learn from a reading, where that is possible."""
        bank, reported = self.bank, np.array([angle, distance], float)
        x, y, yaw = self._pose()
        moved_x, moved_y, turned = self._moved.tolist()
        motion = Motion(moved_x, moved_y, turned, self._far, self._seconds)
        followed = True
        if self._discard:
            bank.skip(motion)
        else:
            followed = bank.read(reported, motion, driven=driven, trusted=not self._doubted,
                                 lost=self._lost)
        again = self._contradicted
        self._contradicted = not (followed or self._doubted or self._lost)
        self._free = None
        if again and self._contradicted:
            self._hurry = FREE_TIME
            self._free = (distance * MM * self.geometry.linear_scale / self._seconds,
                          angle * DEGREE * self.geometry.angular_scale / self._seconds)
        self._discard = self._lost = self._doubted = False
        self._moved[:] = 0.0
        self._seconds = self._far = 0.0
        bx, by, byaw = bank.pose
        if self._placed == (moved_x, moved_y, turned):  # the reading is all of before
            bank.shift(x - bx, y - by, yaw - byaw)
            bx, by, byaw = bank.pose
        self._placed = None
        a, b, c = self._behind
        self._behind = a + bx - x, b + by - y, c + byaw - yaw
        self._start = bank.pose
        self._base = bank.covariance
        self._grown, self._frame = (0.0, 0.0), 0
        self._plan.came()
        self._twist = bank.motion(bank.wheels.speed[:, 0])

    def _pose(self) -> tuple[float, float, float]:
        """Return the mean pose of the bank, predicted since the last reading."""
        x, y, yaw = self._start
        dx, dy, turn = self._moved.tolist()
        c, s = cos(yaw), sin(yaw)
        return x + c * dx - s * dy, y + s * dx + c * dy, yaw + turn

    def _publish(self, dt: float, far: float, turn: float) -> Estimate:
        """Return the estimate a frame further: moved as the wheels, and some way corrected."""
        before, g = self.estimate, self.geometry
        self._hurry = max(0.0, self._hurry - dt)
        limits = (MAX_CORRECTION, MAX_TURN_CORRECTION) if self._hurry <= 0 else (
            FREE_CORRECTION, FREE_TURN_CORRECTION)
        share, twist = blended(self._behind, dt, *limits)
        x, y, yaw = self._behind
        self._behind = x, y, yaw = x * (1 - share), y * (1 - share), yaw - twist
        ex, ey, eyaw = self._pose()
        ex, ey, eyaw = ex - x, ey - y, eyaw - yaw
        middle = (eyaw + before.yaw) / 2
        forward = (ex - before.x) * cos(middle) + (ey - before.y) * sin(middle)
        half = (eyaw - before.yaw) * g.wheel_separation / 2
        speed, rate = far / dt, turn / dt * g.wheel_separation / 2
        if self._frame % GROWTH_EVERY == 0:
            self._grown, self._twist_variance = self.bank.growth()
        self._frame += 1
        self.estimate = Estimate(
            x=ex, y=ey, yaw=eyaw, linear=speed, angular=turn / dt,
            pose_covariance=self._covariance(),
            twist_covariance=self._twist_variance,
            right_wheel=before.right_wheel + (forward + half) / g.wheel_radius,
            right_wheel_speed=(speed + rate) / g.wheel_radius,
            left_wheel=before.left_wheel + (forward - half) / g.wheel_radius,
            left_wheel_speed=(speed - rate) / g.wheel_radius)
        return self.estimate

    def _covariance(self) -> tuple[float, ...]:
        """Return the covariance of the estimate."""
        dx, dy = self._moved[:2].tolist()
        c, s = cos(self._start[2]), sin(self._start[2])
        far, turn = self._grown
        return moved_covariance(
            self._base, (dx * c - dy * s, dx * s + dy * c), self._behind, far, turn)
