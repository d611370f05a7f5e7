# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Pose, twist and covariance from every frame and a reading now and then.

Between readings the tracks predict from the requested speeds, readings correct them and tell which
of them to believe (`filter`, `tracks`). This file decides with the `reading_plan` when to ask, and
follows the tracks' mean smoothly: the estimate moves as they move, and corrections are blended in.
"""

from collections.abc import Callable
from math import cos, exp, hypot, sin

from ..robot import TOP_SPEED, WHEEL_SEPARATION
from .dead_band import DeadBand
from .estimate import Estimate, Geometry, Increment
from .filter import Filter
from .hindsight import Hindsight, Told
from .knowledge import Knowledge, known
from .mean_pose import Pose
from .plain import PlainOdometry
from .reading_plan import ReadingPlan
from .states import DEGREE
from .tracks import LATE, Tracks

BLEND = 0.1
"""Seconds in which a correction is blended in."""
STEP, TWIST = 0.067, 8 * DEGREE
"""The most of a correction that is blended in within a second, m and rad."""
FAR, ASKEW = 0.03, 5 * DEGREE
"""m and rad: a larger correction is blended in as fast as a robot can move, if it moved on its
own, or unseen while frames were lost."""
HASTY = 2.0
"""Seconds after lost frames in which the robot may have moved unseen."""
TOP, TOP_TURN = 1.03 * TOP_SPEED, 2 * 1.03 * TOP_SPEED / WHEEL_SEPARATION
"""How fast a robot can move, m/s and rad/s: the manual's top speed, and 3 % for fast wheels."""
NEAR = 1e-7
"""m and rad by which an estimate that stands need not come nearer to its track."""
CLOSE = 5e-5
"""The same while it moves steadily."""
COVARIANCE_EVERY, STEADY_EVERY = 20, 40
"""Frames from one covariance of the prediction to the next, and while wheels run steadily."""
NEW, NEW_EVERY = 40, 4
"""Readings up to which a robot is new, and the same as above for its wheels: how soon they follow
is what is known least, so doubt grows fast when they are asked for another speed."""
STILL = (0.0, 0.0)
"""The course of a robot that rests."""
AS_BUILT = Geometry()
FLOOR = 1e-9
"""Variance of a pose that is known exactly, m² and rad²."""


class Odometry:
    """Turns increments into an estimate that never jumps."""

    def __init__(self, geometry: Geometry = AS_BUILT, *, window: float = 0.0,
                 robot: Knowledge | None = None) -> None:
        """
        Ask for distance and angle about every `window` seconds, of a robot that is known or not.

        With 0, ask in every frame and believe what the robot says.
        """
        self.geometry = geometry
        self.window = window
        self.estimate = Estimate()
        self._filter = Filter(geometry) if robot is None else Filter(
            geometry, known(robot), DeadBand(*robot.dead_band))
        self._hindsight = Hindsight(geometry) if window and robot is None else None
        """What the filter was told, as long as it may be followed again."""
        self._plain = PlainOdometry(geometry)
        self._plan = ReadingPlan(window)
        self._discard = True
        """Whether the next reading holds what came before; of a robot that is believed."""
        self._caught_up = False
        """Whether the estimate stands where the tracks do."""
        self._patient = False
        """Whether what is to be corrected is no motion of the robot: it comes from a look back, or
        the robot moved less than was believed."""
        self._hasty = 0.0
        """Seconds for which corrections may still be as fast as the robot."""
        self._mark: Pose | None = None
        """Where the robot was at the mark, followed as smoothly as the estimate."""
        self._goal = (0.0, 0.0, 0.0)
        """Where the tracks' mean is."""
        self._covariance = self.estimate.pose_covariance
        self._twist_variance = self.estimate.twist_covariance
        self._unseen = 0
        """Frames since the tracks were last asked how sure they are after a reading."""
        self._same: Increment | None = None
        """What a frame says as long as the robot rests, or moves steadily."""
        self._quiet = self._counted = 0
        """Frames like that for which nothing will be asked, and those that came since the tracks
        were told of one."""
        self._calm: Increment | None = None
        """The last frame, where the wheels run steadily, but the estimate is not on its course."""
        self._course = 0.0, 0.0
        """Metres and radians that the tracks' mean moved by in the last frame."""

    @property
    def tracks(self) -> Tracks:
        """What is believed of the robot."""
        return self._filter.tracks

    @property
    def reading_due(self) -> bool:
        """
        Whether the robot should be asked for distance and angle in its next frame.

        True after one frame for one reading, after several in a row for as many; false while the
        answer is under way.
        """
        return not self.window or self._plan.due

    @property
    def quiet_frames(self) -> int:
        """Frames that say the same as the last one for which no reading will be asked for."""
        if self._calm is not None:
            return self._frames_left(self._calm)
        return max(0, self._quiet - self._counted)

    @property
    def knowledge(self) -> Knowledge | None:
        """What was learned of the robot; None before anything was."""
        return self._filter.knowledge if self.window else None

    @property
    def seeks_rounding(self) -> bool:
        """Whether readings in steady motion would tell how the robot rounds them."""
        return bool(self.window) and len(self.tracks.roundings) > 1

    @property
    def marked(self) -> Pose | None:
        """
        Where the robot was at the mark, as it is known by now; None without one.

        What a robot has done since then is the difference. A correction of what was wrong before
        moves both.
        """
        return self._mark

    def mark(self, *, sparing: bool = False) -> None:
        """
        Mark where the robot is now, for `marked`.

        `sparing`: ask seldom until it is unmarked, as long as the rounding is not known.
        """
        self._wake()
        self._mark, self._plan.sparing = self.estimate[:3], sparing
        if self.window:
            self.tracks.mark()

    def unmark(self) -> None:
        """Forget the mark."""
        self._mark = self.tracks.rows.mark = None
        self._plan.sparing = False

    def reset(self) -> None:
        """Begin again at the origin; what was learned of the robot stays, a mark does not."""
        self._wake()
        self.unmark()
        e = self.estimate
        self.estimate = Estimate(right_wheel=e.right_wheel, left_wheel=e.left_wheel)
        self._tell(Filter.reset)
        self._look()

    def recounted(self) -> None:
        """Learn nothing from the next reading: the robot has set its accumulators to zero."""
        self._discard = True
        self._tell(Filter.recounted)

    def interrupted(self) -> None:
        """Go on from here after frames were missed: the next reading spans an unknown time."""
        self._wake()
        self._discard = True
        self._tell(Filter.interrupted)

    def hurry(self) -> None:
        """Ask for the next reading soon."""
        self._wake()
        self._plan.hurry()

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        if not self.window:
            self.estimate = self._as_reported(increment)
            return self.estimate
        if self._hindsight is not None:
            self._look_back(self._hindsight, increment)
            self._note(increment)
        if self._counted < self._quiet and increment == self._same:
            self._counted += 1
            if self._course != STILL:
                self.estimate = self._further()
            return self.estimate
        self._wake()
        before, settled = self._goal, self.tracks.wheels.settled
        rested = self._move(increment)
        after = before if rested else self.tracks.pose()
        self._goal = after
        self._unseen += 1
        self._learn(increment, rested)
        if rested and self._caught_up and self._unseen:
            self._course = STILL
            self._count(increment)
            return self.estimate  # nothing has moved, nothing was learned
        turned, middle = after[2] - before[2], (after[2] + before[2]) / 2
        went = (after[0] - before[0]) * cos(middle) + (after[1] - before[1]) * sin(middle)
        self.estimate = self._followed(increment.dt, went, turned)
        if settled and self.tracks.wheels.settled:
            if not rested and self._unseen and self._is_on_course:
                self._course = went, turned
                self._count(increment)
            else:
                self._calm = increment
        return self.estimate

    def _learn(self, increment: Increment, rested: bool) -> None:
        """Take in what the frame tells, and look how sure the tracks are where it is time to."""
        if self._filter.read(increment):
            self._plan.came()
            self._patient = self._patient or self._filter.fell_short
            self._look()
            self._unseen = 0
        elif self._is_time_to_look and not rested:
            self._look()
        elif not rested and self._is_time_to_glance:
            self._covariance = self.tracks.pose_covariance(glance=True)
        rows = self.tracks.rows
        if self._mark is not None and rows.mark is not None:
            self._mark = _nearer(self._mark, rows.mark.mean(rows.shares()), increment.dt)
        if self._plan.due:
            self._tell(Filter.asked)

    def _as_reported(self, increment: Increment) -> Estimate:
        if self._discard and increment.distance is not None:
            self._discard = False
            return self.estimate
        return self._plain.after(self.estimate, increment)

    def _tell(self, event: Callable[[Filter], None]) -> None:
        """Tell the filter what has happened, and keep it for one that follows again."""
        event(self._filter)
        self._note(event)

    def _note(self, told: Told) -> None:
        if self._hindsight is not None:
            self._hindsight.note(told)

    def _look_back(self, hindsight: Hindsight, increment: Increment) -> None:
        """Go on with a filter that has followed the past again, once it knows the present."""
        if self._mark is not None or increment.distance is not None:
            return  # the mark is in the tracks; a reading is dear enough
        if other := hindsight.step(self._filter):
            self._wake()
            self._filter, self._patient = other, True
            self._look()
        if hindsight.over:
            self._hindsight = None

    @property
    def _is_on_course(self) -> bool:
        """Whether the estimate moves steadily, and is where the tracks' mean is."""
        if self.tracks.is_free:
            return False
        (x, y, yaw), e = self._goal, self.estimate
        return abs(x - e.x) < CLOSE and abs(y - e.y) < CLOSE and abs(yaw - e.yaw) < CLOSE

    def _count(self, increment: Increment) -> None:
        """Look at the next frames no closer than needed, as long as they say the same."""
        self._same, self._quiet = increment, self._frames_left(increment)

    def _frames_left(self, increment: Increment) -> int:
        """Return how many frames more may say the same until something is asked, or looked at."""
        if self._mark is not None or increment.lost:
            return 0
        dt = increment.dt
        left = int(self._plan.quiet(dt, self.tracks) / dt) - 1
        if self._course == STILL and self.tracks.rests:
            return left
        return min(left, STEADY_EVERY - self._unseen % STEADY_EVERY - 1)

    def _further(self) -> Estimate:
        """Return the estimate a frame further on its course."""
        e, (went, turned), g = self.estimate, self._course, self.geometry
        middle, half = e.yaw + turned / 2, turned * g.wheel_separation / 2
        return e._replace(
            x=e.x + went * cos(middle), y=e.y + went * sin(middle), yaw=e.yaw + turned,
            right_wheel=e.right_wheel + (went + half) / g.wheel_radius,
            left_wheel=e.left_wheel + (went - half) / g.wheel_radius)

    def _wake(self) -> None:
        """Let the time of the frames pass that were only counted."""
        frames, self._counted, self._quiet, self._calm = self._counted, 0, 0, None
        if not frames or self._same is None:
            return
        dt = self._same.dt
        for _ in range(frames):  # one by one: sums of floats depend on their order
            self._filter.rest(self._same)
            self._plan.rest(dt)
        self._unseen += frames
        self._hasty = max(0.0, self._hasty - frames * dt)
        if self._course != STILL:
            self._goal = self.tracks.pose()

    def _move(self, increment: Increment) -> bool:
        """Let the tracks predict, and plan the next reading; True where nothing has moved."""
        dt = increment.dt
        steady = self._filter.is_steady(increment)
        if increment.driven != self._filter.driven:
            self._plan.hurry()
        rested = self._filter.move(increment)
        if self._hasty:
            self._hasty = max(0.0, self._hasty - dt)
        if not steady and dt > LATE:
            self._plan.hurry()
            self._hasty = HASTY
        if self._plan.step(dt, steady=steady, tracks=self.tracks):
            self._tell(Filter.unanswered)
        return rested

    @property
    def _is_time_to_look(self) -> bool:
        frames = STEADY_EVERY if self.tracks.wheels.settled else COVARIANCE_EVERY
        return self._unseen % frames == 0

    @property
    def _is_time_to_glance(self) -> bool:
        return (self.tracks.rows.readings < NEW and not self.tracks.wheels.settled
                and self._unseen % NEW_EVERY == 0)

    def _look(self) -> None:
        """Ask the tracks where the robot is, and how sure they are."""
        self._goal = self.tracks.pose()
        self._covariance = self.tracks.pose_covariance()
        self._twist_variance = self.tracks.twist_variance()
        self._caught_up = False

    def _followed(self, dt: float, went: float, turned: float) -> Estimate:
        """Move the estimate as the tracks' mean moved, and some way towards it."""
        before, g, goal = self.estimate, self.geometry, self._goal
        went = max(-TOP * dt, min(TOP * dt, went))
        turned = max(-TOP_TURN * dt, min(TOP_TURN * dt, turned))
        middle = before.yaw + turned / 2
        dx, dy = went * cos(middle), went * sin(middle)
        x, y, yaw = goal[0] - before.x - dx, goal[1] - before.y - dy, goal[2] - before.yaw - turned
        part = 1 - exp(-dt / BLEND)
        far, askew = hypot(x, y), abs(yaw)
        self._patient = self._patient and (far > FAR or askew > ASKEW)
        hasty = (self.tracks.is_free or self._hasty) and not self._patient
        room = TOP_TURN * dt - abs(turned) if hasty and askew > ASKEW else 0.0
        twist = yaw * _share(part, askew, max(TWIST * dt, room))
        room = TOP * dt - abs(went) if far > FAR else 0.0
        share = _share(part, far, max(STEP * dt, room))
        self._caught_up = not went and not turned and hypot(x, y) < NEAR and abs(yaw) < NEAR
        dx, dy, dyaw = dx + share * x, dy + share * y, turned + twist
        forward = dx * cos(middle) + dy * sin(middle)
        half = dyaw * g.wheel_separation / 2
        rate = turned / dt * g.wheel_separation / 2
        return Estimate(
            x=before.x + dx, y=before.y + dy, yaw=before.yaw + dyaw,
            linear=went / dt, angular=turned / dt,
            pose_covariance=self._spread((1 - share) * x, (1 - share) * y, yaw - twist),
            twist_covariance=self._twist_variance,
            right_wheel=before.right_wheel + (forward + half) / g.wheel_radius,
            right_wheel_speed=(went / dt + rate) / g.wheel_radius,
            left_wheel=before.left_wheel + (forward - half) / g.wheel_radius,
            left_wheel_speed=(went / dt - rate) / g.wheel_radius)

    def _spread(self, x: float, y: float, yaw: float) -> tuple[float, ...]:
        """Return the covariance of an estimate that is so far behind the tracks."""
        xx, xy, xa, _, yy, ya, _, _, aa = self._covariance
        xx, xy, xa = xx + x * x, xy + x * y, xa + x * yaw
        yy, ya, aa = yy + y * y, ya + y * yaw, aa + yaw * yaw
        return xx + FLOOR, xy, xa, xy, yy + FLOOR, ya, xa, ya, aa + FLOOR


def _nearer(pose: Pose, goal: Pose, dt: float) -> Pose:
    """Blend a correction of a pose in for as long as a frame."""
    x, y, yaw = (new - old for new, old in zip(goal, pose))
    part = 1 - exp(-dt / BLEND)
    share, twist = _share(part, hypot(x, y), STEP * dt), _share(part, abs(yaw), TWIST * dt)
    return pose[0] + share * x, pose[1] + share * y, pose[2] + twist * yaw


def _share(part: float, whole: float, most: float) -> float:
    """Return which part of a correction to blend in now."""
    return min(part, most / whole) if whole else 0.0
