"""
Pose, twist and covariance from every frame and a reading now and then.

Between readings the tracks predict from the requested speeds, a reading corrects them (`track`),
and readings also tell which of them to believe (`beliefs`). This file follows the best track
smoothly: the estimate moves as the track moves, and corrections are blended in.
"""

from math import cos, exp, hypot, sin

from .assumptions import DEGREE, TOP_SPEED
from .beliefs import Beliefs
from .estimate import Estimate, Geometry, Increment
from .plain import PlainOdometry
from .reading_plan import ANSWER, ReadingPlan, SLOT

BLEND = 0.1
"""Seconds in which a correction is blended in, ..."""
STEP, TWIST = 1e-3, 0.2 * DEGREE
"""... and the most of it in one frame, m and rad, ..."""
FAR, ASKEW = 0.03, 5 * DEGREE
"""... unless it is larger than this, because the robot moved on its own: then as fast as it can
have moved, ..."""
TOP, TOP_TURN = 1.03 * TOP_SPEED, 2 * 1.03 * TOP_SPEED / 0.258
"""... which is the manual's top speed and 3 % for wheels that are fast, m/s and rad/s."""
LATE = 1.5 * SLOT
"""Seconds between two frames from which on one was lost."""
NEAR = 1e-7
"""m and rad by which an estimate that stands need not come nearer to its track."""
AS_BUILT = Geometry()
FLOOR = 1e-9
"""Variance of a pose that is known exactly, m² and rad²."""


class Odometry:
    """Turns increments into an estimate that never jumps."""

    def __init__(self, geometry: Geometry = AS_BUILT, *, window: float = 0.0) -> None:
        """
        Ask for distance and angle every `window` seconds.

        With 0, ask in every frame and believe what the robot says.
        """
        self.geometry = geometry
        self.window = window
        self.estimate = Estimate()
        self.beliefs = Beliefs(geometry)
        self._plain = PlainOdometry(geometry)
        self._plan = ReadingPlan(window)
        self._discard = True
        self._gap = False
        self._doubt = False
        self._missed: tuple[float, float] | None = None
        """What the accumulators were believed to hold when a reading that was asked for had not
        come, and a frame was lost that may have carried it."""
        self._lost = False
        """Whether frames were lost since a reading was asked for."""
        self._driven = self._lifted = False
        self._at_rest = False
        self._rested = 0.0
        """Seconds of rest that the tracks have not been told of."""
        self._caught_up = False
        """Whether the estimate stands where the best track does."""

    @property
    def reading_due(self) -> bool:
        """
        Whether the robot should be asked for distance and angle in its next frame.

        True after one frame for one reading, after several in a row for as many; false while the
        answer is under way.
        """
        return not self.window or self._plan.due

    def reset(self) -> None:
        """Begin again at the origin; what was learned of the robot stays."""
        e = self.estimate
        self.estimate = Estimate(right_wheel=e.right_wheel, left_wheel=e.left_wheel)
        self._caught_up = False
        for track in self.beliefs.tracks:
            track.reset()

    def recounted(self) -> None:
        """Learn nothing from the next reading: the robot has set its accumulators to zero."""
        self._discard = True

    def interrupted(self) -> None:
        """Go on from here after frames were missed: the next reading spans an unknown time."""
        self._gap = self._doubt = True
        if not self.window:
            self._discard = True

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        if not self.window:
            self.estimate = self._as_reported(increment)
            return self.estimate
        rested = self._move(increment)
        best = self.beliefs.best
        went, turned = best.went, best.turned
        if increment.distance is not None and increment.angle is not None:
            self._read(increment.distance, increment.angle, increment.driven)
        elif rested and self._caught_up:
            return self.estimate  # nothing has moved, nothing was learned
        self.estimate = self._followed(increment.dt, went, turned)
        return self.estimate

    def _as_reported(self, increment: Increment) -> Estimate:
        if self._discard and increment.distance is not None:
            self._discard = False
            return self.estimate
        return self._plain.after(self.estimate, increment)

    def _move(self, increment: Increment) -> bool:
        """Let the tracks predict, and plan the next reading; True where nothing has moved."""
        dt, driven = increment.dt, increment.driven
        right, left = (increment.right, increment.left) if driven else (0.0, 0.0)
        best = self.beliefs.best
        steady = right == best.right.request and left == best.left.request
        usual = steady and not self._gap and increment.lifted == self._lifted
        if increment.lost:
            for track in self.beliefs.tracks:
                track.note_gap(right, left)
        rested = self._at_rest and usual and dt <= LATE
        if rested:
            self._rested += dt
            best.went = best.turned = 0.0
        else:
            self._advance(dt, right, left, increment.lifted)
        if driven != self._driven:
            self._plan.hurry()
        self._gap, self._driven, self._lifted = False, driven, increment.lifted
        lost = self._lost or increment.lost
        if self._plan.step(dt, steady=steady, beliefs=self.beliefs) and lost:
            self._missed = best.distance, best.angle
        self._lost = lost and not self._plan.due
        return rested

    def _advance(self, dt: float, right: float, left: float, lifted: bool) -> None:
        """Let the tracks predict."""
        self._tell_rest()
        late = dt > LATE
        missed = dt - SLOT if late and self.beliefs.best.unseen else 0.0
        for track in self.beliefs.tracks:
            if self._gap:
                track.resume(right, left)
            if lifted != self._lifted:
                track.lift(lifted)
            track.advance(dt - missed, right, left)
            if late:
                track.make_up(missed, SLOT)
        self._at_rest = all(track.stands for track in self.beliefs.tracks)

    def _tell_rest(self) -> None:
        """Tell the tracks how long nothing has moved: there may be many, and frames are many."""
        for track in self.beliefs.tracks:
            track.rest(self._rested)
        self._rested = 0.0

    def _read(self, distance: int, angle: int, driven: bool) -> None:
        self._tell_rest()
        self._plan.came()
        missed, self._missed = self._missed, None
        if self._discard or missed is not None and self.beliefs.best.since(
                missed, distance, angle, ANSWER * SLOT):
            # The first reading may hold travel from before; one that was lost on the line has
            # taken away what this one lacks.
            for track in self.beliefs.tracks:
                track.discard()
        else:
            if self._doubt:
                for track in self.beliefs.tracks:
                    track.doubt(distance, angle)
            self.beliefs.read(distance, angle, driven=driven)
        self._discard = self._doubt = False
        self._at_rest = False  # it may have been pushed

    def _followed(self, dt: float, went: float, turned: float) -> Estimate:
        """Move the estimate as the best track moved, and some way towards it."""
        before, best, g = self.estimate, self.beliefs.best, self.geometry
        went = max(-TOP * dt, min(TOP * dt, went))
        turned = max(-TOP_TURN * dt, min(TOP_TURN * dt, turned))
        middle = before.yaw + turned / 2
        chord = went * (1 - turned * turned / 24)
        dx, dy = chord * cos(middle), chord * sin(middle)
        x, y, yaw = best.x - before.x - dx, best.y - before.y - dy, best.yaw - before.yaw - turned
        part = 1 - exp(-dt / BLEND)
        share = _share(part, hypot(x, y), STEP, FAR, TOP * dt - abs(went))
        self._caught_up = not went and not turned and hypot(x, y) < NEAR and abs(yaw) < NEAR
        twist = yaw * _share(part, abs(yaw), TWIST, ASKEW, TOP_TURN * dt - abs(turned))
        dx, dy, dyaw = dx + share * x, dy + share * y, turned + twist
        forward = dx * cos(middle) + dy * sin(middle)
        half = dyaw * g.wheel_separation / 2
        rate = turned / dt * g.wheel_separation / 2
        return Estimate(
            x=before.x + dx, y=before.y + dy, yaw=before.yaw + dyaw,
            linear=went / dt, angular=turned / dt,
            pose_covariance=self._spread((1 - share) * x, (1 - share) * y, yaw - twist),
            twist_covariance=best.twist_variance,
            right_wheel=before.right_wheel + (forward + half) / g.wheel_radius,
            right_wheel_speed=(went / dt + rate) / g.wheel_radius,
            left_wheel=before.left_wheel + (forward - half) / g.wheel_radius,
            left_wheel_speed=(went / dt - rate) / g.wheel_radius)

    def _spread(self, x: float, y: float, yaw: float) -> tuple[float, ...]:
        """Return the covariance of an estimate that is so far behind the best track."""
        best = self.beliefs.best
        (xx, xy, xa, *_), (_, yy, ya, *_), (_, _, aa, *_) = best.errors.rows[:3]
        leads = [(1.0, x, y, yaw)]
        for rival in self.beliefs.rivals:
            leads.append((rival.weight, rival.x - best.x, rival.y - best.y, rival.yaw - best.yaw))
        for weight, x, y, yaw in leads:
            xx, xy, xa = xx + weight * x * x, xy + weight * x * y, xa + weight * x * yaw
            yy, ya, aa = yy + weight * y * y, ya + weight * y * yaw, aa + weight * yaw * yaw
        return xx + FLOOR, xy, xa, xy, yy + FLOOR, ya, xa, ya, aa + FLOOR


def _share(part: float, whole: float, most: float, far: float, room: float) -> float:
    """Return which part of a correction to blend in now."""
    if whole > far:
        most = max(most, room)
    return min(part, most / whole) if whole else 0.0
