# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A driver and its robot in memory, and what must hold after every step of time."""

from collections import defaultdict
from collections.abc import Callable
from math import hypot, inf, isfinite
from random import Random
from typing import NamedTuple

from create_oi_ros import oi
from create_oi_ros.driver import Activity, DEAD_MAN_STOP, MotionLimits, Moved, Pending, Settings
from create_oi_ros.driver.goal_control import MODE_WAIT
from create_oi_ros.driver.goals import Ending, Goal
from create_oi_ros.odometry import Estimate
from create_oi_ros.robot import SLOT, TOP_SPEED, WHEEL_SEPARATION
from create_oi_ros.sim.body.config import BodyConfig
from create_oi_ros.sim.world import World
from support.loop import Loop, STEP

REACTION = SLOT + 3 * STEP
"""Seconds from a decision of the driver until the robot has obeyed it."""
RECOVERY = 2.0
"""Seconds after a line is whole again in which the robot may still do what it heard before."""
FASTEST, FASTEST_TURN = 1.05 * TOP_SPEED, 2.1 * TOP_SPEED / WHEEL_SEPARATION
SLACK, SLACK_TURN = 0.004, 0.03
"""m and rad of a correction in one frame."""
QUEUE = 300
"""Bytes of commands and events that may wait at most, in pieces."""


class Pursuit(NamedTuple):
    """A goal that was given to the driver."""

    goal: Goal
    began: float
    endings: list[Ending]
    """What was told of its end."""

    def deadline(self) -> float:
        """Return when it must have ended; what the goal leaves open is known once it begins."""
        return self.began + MODE_WAIT + (self.goal.allowance or inf) + REACTION


class WatchedLoop(Loop):
    """Checks after each turn what no sequence of events may break."""

    def __init__(self, config: BodyConfig, settings: Settings, world: World | None = None) -> None:
        super().__init__(settings, config=config, world=world)
        self.random = Random(1)
        self.began = self.now
        self.damage_up = self.damage_down = 0.0
        """Share of the pieces of bytes to the robot, and from it, that are damaged."""
        self.asked_at = self.commanded_at = -inf
        """When a velocity was commanded last that was not zero, and when any was."""
        self.excused_until = -inf
        """Until when the robot may do what nobody commands: it could not be reached."""
        self.replies: list[list[object]] = []
        """What came back for each request."""
        self.pursuits: list[Pursuit] = []
        """All goals."""
        self.pursued_at = -inf
        """When a goal drove the robot last."""
        self.sent: dict[str, set[object]] = defaultdict(set)
        """All values that the robot ever sent."""
        self._spy_on_frames()
        self._before: Moved | None = None

    def request(self, pending: Pending) -> None:
        """Watch a request."""
        got: list[object] = []
        self.replies.append(got)
        pending.then(got.append)

    def pursue(self, goal: Goal) -> None:
        """Give the driver a goal, and watch it."""
        pursuit = Pursuit(self.driver.goals.start(goal, self.now), self.now, [])
        self.pursuits.append(pursuit)
        pursuit.goal.then(pursuit.endings.append)
        self._check_goals()

    def command(self, linear: float, angular: float) -> None:
        """Command a velocity."""
        if isfinite(linear + angular):
            self.commanded_at = self.now
            if linear or angular:
                self.asked_at = self.now
        self.driver.drive(linear, angular, self.now)

    def excuse(self, seconds: float) -> None:
        """Let the robot do what it likes for a while."""
        self.excused_until = max(self.excused_until, self.now + seconds)

    def turn(self) -> None:
        """Let one step of time pass, and check."""
        if self.cut or self.damage_up or not self.driver.state.answered:
            self.excuse(RECOVERY)
        super().turn()
        self._check_goals()
        self._check_wheels()
        self._check_frames()
        assert len(self.driver.core.outbox._queue) < QUEUE

    def _check_goals(self) -> None:
        """One goal runs at most, within its time; the activity says so; each ends once."""
        running = [each for each in self.pursuits[-2:] if each.goal.outcome is None]
        assert len(running) == self.driver.state.pursues
        assert all(self.now <= each.deadline() for each in running), 'a goal runs on'
        if self.driver.state.activity is Activity.GOAL:
            self.pursued_at = self.now

    def _check_wheels(self) -> None:
        """
        Wheels turn only while somebody fresh is in command, or a goal is pursued.

        The robot may have a will of its own, too.
        """
        if not any(self.robot.actuators.wheels) or self.now < self.excused_until:
            return
        if self.robot.demo is not None or self.robot.waiting or self.driver.scripts.playing:
            self.excuse(RECOVERY)  # asked for, or started by damage: until it has been stopped
            return
        limits = self.driver.settings.limits
        age, goal_age = self.now - self.asked_at, self.now - self.pursued_at
        within = limits.timeout + REACTION
        if self.now - self.commanded_at <= within:
            within += braking(limits)  # zeros are commanded, and slow it down
        assert age <= within or goal_age <= REACTION, (
            f'wheels turn {age:.3f} s after the last command, {goal_age:.3f} s after a goal')

    def _check_frames(self) -> None:
        """Nothing is published that the robot did not send; the estimate never steps."""
        for moved in self.moved:
            for name, value in moved.readings.items():
                assert value in self.sent[name], f'{name} = {value} was never sent'
            if self._before is not None:
                assert_small_step(self._before, moved)
            assert_covariance(moved.estimate)
            self._before = moved
        self.moved.clear()

    def stand_still(self, seconds: float) -> None:
        """Let the driver's process stand still; the dead-man has stopped the robot meanwhile."""
        self.robot.receive(DEAD_MAN_STOP, self.now)
        until = self.now + seconds
        while self.now < until:
            self.now += STEP
            self.robot.poll(self.now)
            self._carry(self._down, self.robot.data_to_send())

    def reset_odometry(self) -> None:
        """Put the origin where the robot is: the only step that is allowed."""
        self.request(self.driver.reset_odometry())
        self._before = None

    def _carry(self, line, data: bytes) -> None:
        share = self.damage_up if line is self._up else self.damage_down
        if data and self.random.random() < share:
            data = self._damaged(data)
        super()._carry(line, data)

    def _damaged(self, data: bytes) -> bytes:
        """Flip a bit or lose the end: what a checksum of one byte always notices."""
        place = self.random.randrange(len(data))
        if self.random.random() < 0.5:
            return data[:place]
        flipped = data[place] ^ 1 << self.random.randrange(8)
        return data[:place] + bytes([flipped]) + data[place + 1:]

    def _spy_on_frames(self) -> None:
        take = self.robot.data_to_send

        def spied() -> bytes:
            data = take()
            reader = oi.StreamReader(self.driver.plan.lists)
            reader.feed(data)
            for event in iter(reader.next_event, None):
                if isinstance(event, oi.Frame):
                    for name, value in event.readings.items():
                        self.sent[name].add(value)
            return data
        self.robot.data_to_send: Callable[[], bytes] = spied


def braking(limits: MotionLimits) -> float:
    """Return the most seconds in which a commanded zero is reached."""
    most = ((TOP_SPEED, limits.linear_acceleration),
            (2 * TOP_SPEED / WHEEL_SEPARATION, limits.angular_acceleration))
    return max(speed / acceleration if acceleration else 0.0 for speed, acceleration in most)


def assert_small_step(before: Moved, after: Moved) -> None:
    """Check that an estimate moved no farther than a robot can."""
    a, b, dt = before.estimate, after.estimate, after.stamp - before.stamp
    assert dt > 0
    dt = max(dt, SLOT)  # stamps of frames that came late together are closer
    step, turn = hypot(b.x - a.x, b.y - a.y), abs(b.yaw - a.yaw)
    assert step <= FASTEST * dt + SLACK, f'{step:.3f} m in {dt:.3f} s'
    assert turn <= FASTEST_TURN * dt + SLACK_TURN, f'{turn:.3f} rad in {dt:.3f} s'


def assert_covariance(estimate: Estimate) -> None:
    """Check that a covariance is one."""
    xx, xy, _, yx, yy, _, _, _, aa = estimate.pose_covariance
    assert all(isfinite(value) for value in estimate.pose_covariance)
    assert min(xx, yy, aa) > 0 and abs(xy - yx) < 1e-12
    assert xx * yy >= xy * xy * (1 - 1e-6)
