# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Pose, twist and covariance from every frame and a reading now and then.

Between readings the pose moves as the wheels are believed to, or as a gyro feels it. A reading
corrects the filters; the published pose follows them at a limited rate. A trip, which a goal
starts, is corrected by nothing that was before it.
"""

from math import cos, exp, hypot, sin

import numpy as np

from ..robot import FIRMWARE_SEPARATION, MM_PER_M, SLOT
from .estimate import Estimate, Geometry, GyroSettings, Increment, Knowledge
from .filters import DEGREE, Filters, Window
from .gyro import Gyro, GyroState
from .reading_plan import ReadingPlan
from .wheels import Speeds

BLEND_TIME = 0.1
"""Seconds in which a correction is blended in."""
MAX_CORRECTION, MAX_TURN_CORRECTION = 0.067, 8 * DEGREE
"""The fastest that corrections are blended in, m/s and rad/s: a millimetre a frame."""
FREE_FACTOR, FREE_TIME = 3.5, 6.0
"""How much faster for so many seconds after wheels did not follow: the robot moved so."""
GROWTH_EVERY = 8
"""Frames from one prediction of the covariance to the next: 120 ms."""
LOST = 2.5 * SLOT
"""Seconds between two frames from which on some were lost."""
FLOOR = 1e-8
"""Least variance of a pose, m² and rad²."""
GAP_SPEED, GAP_RATE, GAP_MOST = 0.3, 1.0, 3.0
"""m/s and rad/s that a robot may have driven unseen, and rad at most: half a turn is any."""
UNSEEN_SPEED = 0.03
"""m/s by which a way that the robot chose itself may have bent between two readings (tried)."""
UNSEEN, UNSEEN_UNIT = 0.3, (0.002, 1.0 * DEGREE)
"""Part of an unseen way by which its end may be elsewhere; m and rad of a reading's unit."""
AS_BUILT = Geometry()


class Odometry:
    """Turns increments into an estimate that never jumps."""

    def __init__(self, geometry: Geometry = AS_BUILT, *, window: float,
                 robot: Knowledge | None = None, gyro: GyroSettings | None = None) -> None:
        """Ask for distance and angle every few `window` seconds; the robot is known or not."""
        self.geometry = geometry
        self.estimate = Estimate()
        self.filters = Filters(geometry, robot)
        self._known_gyro = None if robot is None else robot.gyro
        self._gyro = None if gyro is None else Gyro(gyro, self._known_gyro)
        self._begin_gyro()
        self._plan = ReadingPlan(window)
        self._window = Window()
        self._discard = True
        """Whether the next reading holds what came before."""
        self._lost = self._doubted = False
        """Whether the next reading may not be whole; whether nothing was requested of its way."""
        self._gap = self._hurry = 0.0
        """Seconds of its window that nobody saw, and for which corrections may be fast."""
        self._trip_after_gap = False
        """Whether the trip has begun after these seconds."""
        self._behind = (0.0, 0.0, 0.0)
        """What of the corrections is not blended in yet."""
        self._frame = 0
        self._ungrown = self._unsure = (0.0, 0.0)
        self._grow()

    @property
    def reading_due(self) -> bool:
        """Whether the robot should be asked for distance and angle in its next frame."""
        return self._plan.due

    @property
    def reading_asked(self) -> bool:
        """Whether an answer with distance and angle may be on its way."""
        return self._plan.asked

    @property
    def gyro(self) -> GyroState | None:
        """What is thought of the gyro; None: there is none."""
        return None if self._gyro is None else self._gyro.state

    @property
    def knowledge(self) -> Knowledge | None:
        """What was learned of the robot; None before anything was."""
        if not self.filters.readings:
            return None
        return self.filters.knowledge(self._gyro and self._gyro.known or self._known_gyro)

    def reset(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> None:
        """Go on from a pose, m and rad; what was learned of the robot stays."""
        self._split()
        self.filters.place(x, y, yaw)
        self._behind, self._gap = (0.0, 0.0, 0.0), 0.0
        self.estimate = self.estimate._replace(x=x, y=y, yaw=yaw)
        self._grow()

    def start_trip(self) -> None:
        """Let `Estimate.trip` go on from here without corrections of what was before."""
        self._split()
        self._trip_after_gap = self._gap > 0
        self.filters.start_trip()
        self._grow()
        self.estimate = self.estimate._replace(trip=self.filters.trip, trip_variance=(0.0, 0.0))

    def recounted(self) -> None:
        """Learn nothing from the next reading: the robot has set its accumulators to zero."""
        self._discard = True

    def interrupted(self, seconds: float) -> None:
        """Go on from here after so many seconds were missed: the next reading tells of them."""
        self._gap += max(seconds, SLOT)
        if self._gyro is not None:
            self._gyro.felt.unmeasured += self._gyro.felt.frames + 1

    def hurry(self) -> None:
        """Ask for the next reading soon."""
        self._plan.hurry()

    # Frames.

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        dt, w, wheels = increment.dt, self._window, self.filters.wheels
        request = increment.right, increment.left
        far, turn = self._roll(dt, request, lifted=increment.lifted)
        if increment.lifted:
            far = turn = 0.0
        self._lost |= increment.lost or increment.lifted
        self._doubted |= increment.by_itself
        measured = False
        if self._gyro is not None:
            turn, measured = self._gyro.turn(
                dt, increment.analog, turn, moved=wheels.moving or any(request),
                touched=increment.lifted or increment.bumped)
        w.advance(far, turn)
        if increment.distance is not None and increment.angle is not None:
            self._read(increment.distance, increment.angle)
        self._frame += 1
        if self._frame % GROWTH_EVERY == 0:
            self._grow()
        elif any(request):
            way, angle = self._ungrown
            self._ungrown = (way + abs(request[0] + request[1]) / 4 * dt,
                             angle + abs(request[0] - request[1]) / 2 / FIRMWARE_SEPARATION * dt)
        self._plan.step(dt, request, self.filters, self._unsure)
        return self._publish(dt, far, turn, measured=measured)

    def _roll(self, dt: float, request: Speeds, *, lifted: bool) -> tuple[float, float]:
        """Return how far the robot went, m, and turned, rad, in a frame by its wheels."""
        w, wheels = self._window, self.filters.wheels
        far = turn = 0.0
        # Where frames were lost, the wheels ran as requested before until the last slot.
        missed = dt - SLOT if dt > LOST else 0.0
        for seconds, asked in ((missed, wheels.request), (dt - missed, request)):
            if not seconds:
                continue
            if asked != wheels.request:
                w.change(asked)
            ways = wheels.roll(seconds, asked, lifted=lifted)
            w.step(seconds, rolling=wheels.moving)
            more, bent = self.filters.motion(ways, seconds, kept=w.kept)
            far, turn = far + more, turn + bent
        return far, turn

    def _read(self, distance: int, angle: int) -> None:
        """Let the filters learn from a reading, where that is possible."""
        f, before = self.filters, self._pose()
        if self._gap and not self._discard:
            self._jump(distance, angle)
        else:
            f.advance(self._window, doubted=self._doubted)
            f.take(None if self._discard else (angle, distance), self._window.seconds,
                   lost=self._lost)
            if self._doubted:
                place = (UNSEEN_SPEED * self._window.seconds) ** 2
                f.shift(np.zeros(5), np.array([place, place, 0.0, 0.0, 0.0]))
        if self._gap or self._doubted or not f.followed:
            self._hurry = FREE_TIME
        self._discard = self._lost = self._doubted = False
        self._gap = 0.0
        self._begin_window()
        self._blend_from(before)
        self._grow()
        self._plan.came()

    def _jump(self, distance: int, angle: int) -> None:
        """Go where a reading says that a robot went while nobody saw it: along an arc."""
        g, f, gap = self.geometry, self.filters, self._gap
        f.advance(self._window)
        held_angle, held_distance = f.held
        far = (distance - held_distance) / MM_PER_M * g.linear_scale
        turn = (angle - held_angle) * DEGREE * g.angular_scale
        place, heading = (UNSEEN * far) ** 2 + UNSEEN_UNIT[0] ** 2, UNSEEN_UNIT[1] ** 2
        if abs(distance) < abs(held_distance) - 1 or abs(angle) < abs(held_angle) - 1:
            # A reading was lost: nobody knows.
            far = turn = 0.0
            place, heading = (GAP_SPEED * gap) ** 2, min(GAP_RATE * gap, GAP_MOST) ** 2
        chord = far * (sin(turn / 2) / (turn / 2) if turn else 1.0)
        middle = f.yaw + self._window.turn + turn / 2
        of_trip = not self._trip_after_gap
        f.shift(np.array([chord * cos(middle), chord * sin(middle), turn,
                          of_trip * far, of_trip * turn]),
                np.array([place, place, heading, of_trip * place, of_trip * heading]))
        f.take(None, self._window.seconds)

    def _split(self) -> None:
        """End the window here, without a reading."""
        before = self._pose()
        self.filters.advance(self._window)
        self._begin_window()
        self._blend_from(before)

    def _blend_from(self, before: tuple[float, float, float]) -> None:
        """Let the published pose follow one that was corrected."""
        (bx, by, byaw), (x, y, yaw) = self._behind, self._pose()
        self._behind = bx + x - before[0], by + y - before[1], byaw + yaw - before[2]

    def _begin_window(self) -> None:
        """Begin a window where the filters are."""
        f, gyro = self.filters, self._gyro
        if gyro is None or not gyro.felt.frames:  # a goal may begin with a reading
            f.begin()
        else:
            f.take_turn(gyro, self._window)
            f.begin()
            if gyro.anew:  # it was no gyro that turned the pose
                self._hurry = FREE_TIME
            gyro.learned(*f.gyro, self._window.turn)
            self._begin_gyro()
        self._window = Window(near=self._window.near)

    def _begin_gyro(self) -> None:
        """Let the filters begin with a gyro of which they know nothing yet."""
        if self._gyro is not None and self._gyro.anew:
            self.filters.begin_gyro(self._gyro.zero, self._gyro.scale_error)
            self._gyro.anew = False

    def _pose(self) -> tuple[float, float, float]:
        """Return the mean pose of the filters, moved since the last reading."""
        (x, y, yaw), w = self.filters.pose, self._window
        c, s = cos(yaw), sin(yaw)
        return x + c * w.x - s * w.y, y + s * w.x + c * w.y, yaw + w.turn

    # What is published.

    def _grow(self) -> None:
        """Work out the covariances now."""
        gyro = self._gyro
        by_gyro = None if gyro is None or not gyro.state.believed else (
            gyro.scale ** 2 * gyro.felt.variance
            + (gyro.scale * gyro.zero.deviation * gyro.felt.seconds) ** 2
            + (gyro.scale_error.deviation * self._window.turn) ** 2)
        self._ungrown = 0.0, 0.0
        self._moved, self._twist, self._unsure = self.filters.grown(self._window, by_gyro)

    def _publish(self, dt: float, far: float, turn: float, *, measured: bool) -> Estimate:
        """Return the estimate a frame further: moved, and some way corrected."""
        before, g, gyro = self.estimate, self.geometry, self._gyro
        self._hurry = max(0.0, self._hurry - dt)
        part, quick = 1 - exp(-dt / BLEND_TIME), FREE_FACTOR if self._hurry else 1.0
        x, y, yaw = self._behind
        off = hypot(x, y)
        share = min(part, quick * MAX_CORRECTION * dt / off) if off else 0.0
        twist = min(part, quick * MAX_TURN_CORRECTION * dt / abs(yaw)) if yaw else 0.0
        self._behind = x, y, yaw = x * (1 - share), y * (1 - share), yaw * (1 - twist)
        ex, ey, eyaw = self._pose()
        ex, ey, eyaw = ex - x, ey - y, eyaw - yaw
        middle, half = (eyaw + before.yaw) / 2, (eyaw - before.yaw) * g.wheel_separation / 2
        forward = (ex - before.x) * cos(middle) + (ey - before.y) * sin(middle)
        speed, rate = far / dt, turn / dt * g.wheel_separation / 2
        linear, angular = self._twist
        felt = None
        if gyro is not None and gyro.state.believed and measured:
            felt = gyro.rate, gyro.variance
            angular = min(angular, gyro.variance)
        (way, turned), w = self.filters.trip, self._window
        self.estimate = Estimate(
            x=ex, y=ey, yaw=eyaw, linear=speed, angular=turn / dt,
            pose_covariance=self._covariance(),
            twist_covariance=(linear, angular),
            right_wheel=before.right_wheel + (forward + half) / g.wheel_radius,
            right_wheel_speed=(speed + rate) / g.wheel_radius,
            left_wheel=before.left_wheel + (forward - half) / g.wheel_radius,
            left_wheel_speed=(speed - rate) / g.wheel_radius,
            gyro=felt, trip=(way + w.way, turned + w.turn),
            trip_variance=(self._moved[3][3], self._moved[4][4]))
        return self.estimate

    def _covariance(self) -> tuple[float, ...]:
        """Return the covariance of the published pose."""
        (xx, xy, xa, *_), (_, yy, ya, *_), (_, _, aa, *_), *_ = self._moved
        x, y, yaw = self._behind
        far, turn = self._ungrown
        place = (GAP_SPEED * self._gap) ** 2 + far * far + FLOOR
        heading = min(GAP_RATE * self._gap, GAP_MOST) ** 2 + turn * turn + FLOOR
        xx, yy, aa = xx + x * x + place, yy + y * y + place, aa + yaw * yaw + heading
        xy, xa, ya = xy + x * y, xa + x * yaw, ya + y * yaw
        return xx, xy, xa, xy, yy, ya, xa, ya, aa
