# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A gyro beside the wheels: it measures the turning between readings and where wheels slip.

A Kalman filter holds the errors of the pose and of the gyro's zero, its drift and its scale. With
each reading of the robot's counts it compares two turns since the reading before: by the gyro, and
by the wheels' own odometry, of which nothing changes. Where both agree, each corrects the other;
so the zero is learned whenever the robot stands. Where they disagree by more than both can
explain, wheels slip or somebody turns the robot: the gyro is believed, and nothing is learned.

It is believed only after it has followed the wheels in turns, and while its voltage is one that a
gyro can have. Before, and else, the odometry is that of the wheels.
"""

from dataclasses import dataclass, replace
from math import cos, hypot, isnan, nan, radians, sin
from typing import NamedTuple

import numpy as np

from .estimate import Estimate, Increment
from .hypotheses import Array, DEGREE
from .knowledge import Knowledge, Known, KnownGyro
from .odometry import blended, moved_covariance, Odometry

X, Y, YAW, ZERO, DRIFT, SCALE = range(6)
"""The errors in the filter: m, m, rad; V, V/s, and a part of the scale."""
LOWEST, HIGHEST, STEP = 0.0, 5.0, 5.0 / 1023
"""Volts of the analog input, and its resolution."""
ANY_ZERO, ANY_DRIFT, ANY_SCALE = 1.5, 1e-5, 0.03
"""Standard deviations of a gyro that nobody has checked: V, V/s, a part of the scale."""
STALE_ZERO, STALE_SCALE = 0.005, 5e-4
"""By how much a gyro that was checked may have changed until the next start."""
ZERO_WALK, DRIFT_WALK = 1e-10, 1e-14
"""Variances by which zero and drift change in a second, V²/s and V²/s³."""
REST_TURN, WHEEL_TURN, WHEEL_SHARE, WHEEL_WAY = 0.02 * DEGREE, 0.15 * DEGREE, 0.003, 0.01
"""What the wheels' own variance does not tell: rad between two readings at rest and in motion;
parts of the turn and of the way."""
GATE = 12.0
"""Squared standard deviations beyond which wheels and gyro disagree."""
LEAST_TURN, MOST_DOUBT = 10 * DEGREE, 0.1
"""A turn that tells whether a gyro follows, and the part of it that must be sure."""
PROOFS, DISPROOFS = 2, 4
"""Turns in a row in which it must follow to be believed, or that show that it does not."""
SURE_ZERO = 0.3 * DEGREE
"""rad/s; with a zero less sure than that it is not used."""
SLIP_FADES = 0.8
"""Part of a slip that is still expected after a turn without one."""
JUMP, JUMPS, MOST_JUMPS = 25 * STEP, 5, 0.2
"""V by which the voltage may leave its course from frame to frame; frames in a row in which it may
do so; part of all frames."""
ASTRAY = 0.9
"""Part of a turn of the wheels by which a gyro that follows seldom disagrees."""
LONGEST_GAP = 0.1
"""Seconds between two frames, from which on nobody knows how the robot turned."""
LEAST_NOISE, NOISE_SHARE = (0.4 * STEP) ** 2, 0.1
"""Least variance of a voltage, V²; part by which a reading at rest changes it."""
GUESSED = 0.05
"""Part by which the wheels' turn may be off in frames in which only they tell it."""
NEAR_RANGE = 0.95
"""Part of its range from which on it is not believed."""
MOVED_ZERO = 10
"""Readings in a row at rest that disagree, after which the zero is learned anew."""
QUIET = 16.0
"""Squared standard deviations of a turn that is taken for noise while the wheels stand."""


class GyroSettings(NamedTuple):
    """An analog gyro, by its data sheet; the defaults are those of an ADXRS613."""

    scale: float = radians(80.0)
    """rad/s for each volt; negative where the voltage grows clockwise."""
    range: float = radians(150.0)
    """rad/s at which its output ends."""


class GyroState(NamedTuple):
    """What is thought of the gyro and, by it, of the wheels."""

    believed: bool
    problem: str | None
    """Why it is not believed; None where nothing is wrong."""
    slips: int
    """Readings, since the start, at which wheels and gyro disagreed."""
    slips_now: bool
    """Whether they did at the last reading."""


@dataclass
class Window:
    """What happened since the last reading; metres and radians."""

    seconds: float = 0.0
    turn: float = 0.0
    x: float = 0.0
    y: float = 0.0
    way: float = 0.0
    variance: float = 0.0
    """Of the turn, by the noise of the gyro."""
    frames: int = 0
    unmeasured: int = 0
    """Frames in which the gyro did not tell the turn."""
    guessed: float = 0.0
    """Their turn, by the wheels."""
    jumps: int = 0
    bends: float = 0.0
    """Sum of the squared second differences of the voltage, V²."""
    moved: bool = False
    """Whether the wheels turned, or were told to."""
    loud: bool = False
    """Whether the gyro told a turn that is no noise though the wheels stand."""
    touched: bool = False
    """Whether a wheel hung down or the bumper was pressed: somebody may turn the robot."""


class GyroOdometry:
    """The odometry of a robot with a gyro: the wheels', with the heading of both."""

    def __init__(self, wheels: Odometry, settings: GyroSettings,
                 known: KnownGyro | None = None) -> None:
        """Begin with a gyro of which nothing is known but its data sheet, or that was checked."""
        self.wheels = wheels
        self.estimate = wheels.estimate
        self.state = GyroState(False, 'its zero is not known yet: let the robot stand', 0, False)
        self._range = settings.range
        self._scale, self._zero, self._drift = settings.scale, 2.5, 0.0
        doubts = (ANY_ZERO, ANY_DRIFT, ANY_SCALE)
        if known is not None:
            self._scale, self._zero, self._drift = (
                radians(known.scale.value), known.zero.value, known.drift.value)
            doubts = (hypot(known.zero.deviation, STALE_ZERO), known.drift.deviation + 1e-7,
                      hypot(known.scale.deviation / known.scale.value, STALE_SCALE))
        self._p = np.diag([0.0, 0.0, 0.0, *(each ** 2 for each in doubts)])
        self._agreed = PROOFS if known is not None else 0
        self._disagreed = self._moved_zero = 0
        self._noise = STEP ** 2
        """Variance of a voltage, V²."""
        self._used = self._merged = False
        """Whether the heading is the gyro's, too, and whether it ever was."""
        self._slip = 0.0
        """Part of a turn by which wheels slip, as far as they did lately."""
        self._window = Window()
        self._volts = self._volts_before = nan
        """Of the last two frames."""
        self._rate = 0.0
        self._jumpy = 0
        self._heading = wheels.heading
        self._yaw = self._heading[0]
        """Yaw at the last reading."""
        self._behind = (0.0, 0.0, 0.0)
        """Corrections that are not blended in yet."""

    # As the wheels' odometry has it.

    @property
    def reading_due(self) -> bool:
        """Whether the robot should be asked for distance and angle in its next frame."""
        return self.wheels.reading_due

    @property
    def knowledge(self) -> Knowledge | None:
        """What was learned of the robot; None before anything was."""
        known = self.wheels.knowledge
        if known is None or not self._agreed:
            return known
        zero, drift, scale = (float(self._p[each, each]) ** 0.5 for each in (ZERO, DRIFT, SCALE))
        of_scale = self._scale / DEGREE
        return replace(known, gyro=KnownGyro(
            Known(self._zero, zero), Known(self._drift, drift),
            Known(of_scale, scale * abs(of_scale))))

    def reset(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> None:
        """Go on from a pose, m and rad; what was learned of robot and gyro stays."""
        self.wheels.reset(x, y, yaw)
        self._heading = self.wheels.heading
        self._yaw += yaw - self.estimate.yaw
        self.estimate = self.estimate._replace(x=x, y=y, yaw=yaw)
        self._behind = (0.0, 0.0, 0.0)
        self._p[:ZERO, :] = self._p[:, :ZERO] = 0.0

    def recounted(self) -> None:
        """Learn nothing from the next reading: the robot has set its accumulators to zero."""
        self.wheels.recounted()

    def interrupted(self) -> None:
        """Go on from here after frames were missed."""
        self.wheels.interrupted()
        self._window.unmeasured += self._window.frames + 1

    def hurry(self) -> None:
        """Ask for the next reading soon."""
        self.wheels.hurry()

    # Frames.

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        before = self.wheels.estimate
        e = self.wheels.update(increment)
        w, dt = self._window, increment.dt
        w.seconds += dt
        w.frames += 1
        w.touched |= increment.lifted or increment.bumped
        w.moved |= bool(e.linear or e.angular or increment.right or increment.left)
        rolled, turn = e.yaw - before.yaw, self._turn(increment.analog, dt)
        if turn is None:
            w.unmeasured += 1
            w.guessed += abs(rolled)
        w.turn += rolled if turn is None else turn
        step = self._published_turn(rolled, turn)
        self._move(e, before, step, dt)
        if increment.distance is not None and increment.angle is not None:
            self._read()
        self._publish(e, turn is not None)
        return self.estimate

    def _turn(self, volts: float | None, dt: float) -> float | None:
        """Return the turn in a frame by the gyro, rad; None: it does not tell."""
        if volts is None:
            return None
        if isnan(self._volts):
            self._volts = self._volts_before = volts
        w = self._window
        bend = volts - 2 * self._volts + self._volts_before
        self._volts_before, self._volts = self._volts, volts
        w.bends += bend * bend
        jumps = abs(bend) > JUMP
        w.jumps += jumps
        self._jumpy = min(self._jumpy + 1, 2 * JUMPS) if jumps else max(self._jumpy - 1, 0)
        rate = (volts - self._zero) * self._scale
        before, self._rate = self._rate, rate
        w.variance += (self._scale * dt) ** 2 * (self._noise + (bend * bend / 12 if jumps else 0))
        at_end = not LOWEST < volts < HIGHEST - STEP / 2 or (
            self._used and abs(rate) > NEAR_RANGE * self._range)
        if at_end or self._jumpy > JUMPS or dt > LONGEST_GAP:
            return None
        return (before + rate) / 2 * dt

    def _published_turn(self, rolled: float, turn: float | None) -> float:
        """Return by how much the published heading turns in a frame."""
        if not self._used or turn is None:
            return rolled
        w = self._window
        if w.moved or w.touched or w.loud:
            return turn
        noise = w.variance + (self._scale * w.seconds) ** 2 * float(self._p[ZERO, ZERO])
        if w.turn ** 2 < QUIET * noise:
            return 0.0
        w.loud = True
        x, y, _ = self._behind
        self._behind = x, y, self._yaw + w.turn - self.estimate.yaw - turn
        return turn

    def _move(self, e: Estimate, before: Estimate, turn: float, dt: float) -> None:
        """Move the published pose as the wheels did, but on the heading of both."""
        was, w = self.estimate, self._window
        dx, dy, old = e.x - before.x, e.y - before.y, (e.yaw + before.yaw) / 2
        bent = was.yaw + turn / 2 - old
        c, s = cos(bent), sin(bent)
        dx, dy = c * dx - s * dy, s * dx + c * dy
        w.x, w.y = w.x + dx, w.y + dy
        w.way += hypot(dx, dy)
        share, twist = blended(self._behind, dt)
        x, y, yaw = self._behind
        self._behind = x * (1 - share), y * (1 - share), yaw - twist
        self.estimate = was._replace(x=was.x + dx + x * share, y=was.y + dy + y * share,
                                     yaw=was.yaw + turn + twist)

    def _publish(self, e: Estimate, measured: bool) -> None:
        """Add the speeds and the variances to the published pose."""
        variance = self._scale ** 2 * (self._noise + float(self._p[ZERO, ZERO])) + (
            self._rate ** 2 * float(self._p[SCALE, SCALE]))
        gyro = (self._rate, variance) if self._used and measured else None
        if not self._merged:
            self.estimate = e._replace(gyro=gyro)
            return
        turning, of_turning = e.angular, e.twist_covariance[1]
        if gyro is not None:
            if (self._rate - turning) ** 2 < GATE * (variance + of_turning):
                share = of_turning / (variance + of_turning)
                turning += share * (self._rate - turning)
                of_turning *= 1 - share
            else:
                turning, of_turning = self._rate, variance
        self.estimate = e._replace(
            x=self.estimate.x, y=self.estimate.y, yaw=self.estimate.yaw, angular=turning,
            twist_covariance=(e.twist_covariance[0], of_turning),
            pose_covariance=self._covariance(), gyro=gyro)

    def _covariance(self) -> tuple[float, ...]:
        """Return the covariance of the published pose."""
        w = self._window
        turn = w.variance + (max(self._slip, GUESSED) * w.guessed) ** 2
        return moved_covariance(
            self._p[:ZERO, :ZERO], (w.x, w.y), self._behind, (WHEEL_WAY * w.way) ** 2, turn)

    # Readings.

    def _read(self) -> None:
        """Compare both turns since the last reading; learn from them where that is possible."""
        w, self._window = self._window, Window()
        before, self._heading = self._heading, self.wheels.heading
        turned = self._heading[0] - before[0]
        doubt = abs(self._heading[1] - before[1]) + (WHEEL_SHARE * turned) ** 2 + (
            WHEEL_TURN if w.moved else REST_TURN) ** 2
        w.moved |= abs(turned) > WHEEL_TURN
        after, crossed = self._predicted(w)
        slips, measured = False, w.unmeasured <= w.frames / 2
        by_gyro = self._used and measured
        self._yaw += w.turn if by_gyro else turned
        if measured and not w.touched:
            slips = self._compare(w, turned, doubt, after, crossed)
        if not by_gyro:
            doubt += (self._slip * turned) ** 2
            after[YAW, :] = after[:, YAW] = 0.0
            after[YAW, YAW] = self._p[YAW, YAW] + doubt
        self._p = after
        self._judge(w, turned, slips)
        e = self.wheels.estimate
        x, y, _ = self._behind
        waits = 0.0 if self._used else self._heading[0] - e.yaw
        self._behind = x, y, self._yaw - self.estimate.yaw - waits

    def _predicted(self, w: Window) -> tuple[Array, Array]:
        """Return the covariance after a window, and that of then with now."""
        f = np.eye(6)
        f[YAW, ZERO:] = -self._scale * w.seconds, -self._scale * w.seconds ** 2 / 2, w.turn
        f[ZERO, DRIFT] = w.seconds
        for axis, lever in ((X, -w.y), (Y, w.x)):
            f[axis, YAW], f[axis, ZERO:] = lever, f[YAW, ZERO:] * lever / 2
        crossed: Array = f @ self._p
        after: Array = crossed @ f.T
        far = (WHEEL_WAY * w.way) ** 2
        guessed = (max(self._slip, GUESSED) * w.guessed) ** 2
        after[range(6), range(6)] += (
            far, far, w.variance + guessed, ZERO_WALK * w.seconds, DRIFT_WALK * w.seconds, 0.0)
        self._zero += self._drift * w.seconds
        return after, crossed

    def _compare(self, w: Window, turned: float, doubt: float, after: Array, crossed: Array,
                 ) -> bool:
        """Let wheels and gyro correct each other; return whether they disagree."""
        known = after[:, YAW] - crossed[:, YAW]
        own = float(known[YAW] - crossed[YAW, YAW] + self._p[YAW, YAW])
        surprise, turn = turned - w.turn, max(abs(turned), abs(w.turn))
        slips = surprise ** 2 > GATE * (own + doubt)
        if turn > LEAST_TURN and own + doubt < (MOST_DOUBT * turn) ** 2:
            self._count(w, turned, slips)
        self._moved_zero = self._moved_zero + 1 if slips and not w.moved else 0
        if self._moved_zero >= MOVED_ZERO:
            after[ZERO, :] = after[:, ZERO] = 0.0
            after[ZERO, ZERO] = ANY_ZERO ** 2
        if slips:
            self._slip = max(self._slip, min(1.0, abs(surprise) / max(turn, LEAST_TURN)))
            astray = (surprise * self.wheels.geometry.wheel_separation / 2) ** 2
            after[X, X] += astray
            after[Y, Y] += astray
            return True
        gain = known / (own + doubt + (self._slip * turn) ** 2)
        after -= np.outer(gain, known)
        if turn > LEAST_TURN:
            self._slip *= SLIP_FADES
        corrections = (gain * surprise).tolist()
        self._zero += corrections[ZERO]
        self._drift += corrections[DRIFT]
        self._scale *= 1 + corrections[SCALE]
        if self._used:
            x, y, yaw = self._behind
            self._behind = x + corrections[X], y + corrections[Y], yaw
            self._yaw += corrections[YAW]
        if not w.moved:
            noise = w.bends / 6 / w.frames
            self._noise += NOISE_SHARE * (max(noise, LEAST_NOISE) - self._noise)
        return False

    def _count(self, w: Window, turned: float, slips: bool) -> None:
        """Count turns in which the gyro follows the wheels, and in which not; find its sign."""
        if not slips:
            self._agreed, self._disagreed = min(self._agreed + 1, PROOFS), 0
        elif self._agreed < PROOFS or abs(turned - w.turn) > ASTRAY * abs(turned):
            self._disagreed += 1
            if self._disagreed >= DISPROOFS:
                self._agreed = 0
                if turned * w.turn < -turned ** 2 / 2:
                    self._scale, self._disagreed = -self._scale, 0

    def _judge(self, w: Window, turned: float, slips: bool) -> None:
        """Decide whether the gyro is believed until the next reading."""
        problem = self._problem(w, turned)
        self._used = problem is None
        slips &= self._used
        self.state = GyroState(self._used, problem, self.state.slips + slips, slips)
        if self._used and not self._merged:
            self._merged = True
            self._p[:ZERO, :] = self._p[:, :ZERO] = 0.0
            self._p[:ZERO, :ZERO] = np.reshape(self.wheels.estimate.pose_covariance, (3, 3))

    def _problem(self, w: Window, turned: float) -> str | None:
        """Say why the gyro is not believed; None: it is."""
        if w.jumps > max(JUMPS, MOST_JUMPS * w.frames):
            return 'the voltage jumps: is a gyro connected to the analog input?'
        if w.unmeasured > w.frames / 2:
            return (f'{self._volts:.2f} V are beyond its range, or frames come without packet 33')
        if not w.bends and abs(turned) > LEAST_TURN:
            self._agreed = 0
            return f'the voltage stays at {self._volts:.2f} V though the robot turns: is it there?'
        if self._disagreed >= DISPROOFS:
            return 'it does not follow the turns of the wheels: are gyro_scale and wiring right?'
        if abs(self._scale) * float(self._p[ZERO, ZERO]) ** 0.5 > SURE_ZERO:
            return 'its zero is not known yet: let the robot stand'
        if self._agreed < PROOFS:
            return 'it has not been seen to follow the wheels yet: turn the robot'
        return None
