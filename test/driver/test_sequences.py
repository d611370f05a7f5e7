# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Any sequence of commands, goals, requests, faults and hands on the robot ends well.

A sequence that fails is printed as a short program.
"""

from collections import defaultdict
from collections.abc import Callable
from math import hypot, inf, isfinite, nan
from random import Random
from typing import NamedTuple

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, rule, RuleBasedStateMachine, run_state_machine_as_test
import pytest

from create_oi_ros import oi
from create_oi_ros.driver import (
    Activity,
    DEAD_MAN_STOP,
    MotionLimits,
    Moved,
    Outcome,
    Pending,
    Settings,
)
from create_oi_ros.driver.goal_control import CANCELED, CLIENT_GONE, MODE_WAIT
from create_oi_ros.driver.goals import Dock, Goal, Undock
from create_oi_ros.odometry import Estimate
from create_oi_ros.oi.script import build_script
from create_oi_ros.robot import SLOT, TOP_SPEED, WHEEL_SEPARATION
from create_oi_ros.sim.body.config import BodyConfig, DEFAULT_BODY, IDEAL
from create_oi_ros.sim.world import parse, World
from support.goals import angle, arc, distance, place
from support.loop import Loop, STEP
from support.nightly import NIGHTLY, times

REACTION = SLOT + 3 * STEP
"""Seconds from a decision of the driver until the robot has obeyed it."""
RECOVERY = 2.0
"""Seconds after a line is whole again in which the robot may still do what it heard before."""
FASTEST, FASTEST_TURN = 1.05 * TOP_SPEED, 2.1 * TOP_SPEED / WHEEL_SEPARATION
SLACK, SLACK_TURN = 0.004, 0.03
"""m and rad of a correction in one frame."""


class Pursuit(NamedTuple):
    """A goal that was given to the driver."""

    goal: Goal
    began: float
    endings: list[Outcome]
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
        self.stopped = False
        """Whether nothing that moves the wheels was asked for since a stop."""
        self._written = oi.CommandReader()
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
        self.stopped = False
        pursuit = Pursuit(self.driver.goals.start(goal, self.now), self.now, [])
        self.pursuits.append(pursuit)
        pursuit.goal.then(pursuit.endings.append)
        self._check_goals()

    def command(self, linear: float, angular: float) -> None:
        """Command a velocity."""
        if isfinite(linear + angular):
            self.commanded_at = self.now
            if linear or angular:
                self.asked_at, self.stopped = self.now, False
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
        assert self.driver.state.pursues or self.driver.modes.own is self.driver.status.wanted, (
            'the mode of a goal that has ended is still wanted')

    def _check_goals(self) -> None:
        """One goal runs at most, within its time; the activity says so; each ends once."""
        running = [each for each in self.pursuits if each.goal.outcome is None]
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
        super().stand_still(seconds)

    def reset_odometry(self) -> None:
        """Put the origin where the robot is: the only step that is allowed."""
        self.request(self.driver.reset_odometry())
        self._before = None

    def _check_written(self, data: bytes) -> None:
        """After a stop the driver writes no speed, whatever the robot may have missed."""
        self._written.feed(data)
        for command in iter(self._written.next_event, None):
            if isinstance(command, oi.DriveDirect) and self.stopped:
                assert command.right == command.left == 0, f'{command} after a stop'

    def _carry(self, line, data: bytes) -> None:
        if line is self._up:
            self._check_written(data)
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
    frames = dt / SLOT  # those that were lost as well
    assert step <= FASTEST * dt + SLACK * frames, f'{step:.3f} m in {dt:.3f} s'
    assert turn <= FASTEST_TURN * dt + SLACK_TURN * frames, f'{turn:.3f} rad in {dt:.3f} s'


def assert_covariance(estimate: Estimate) -> None:
    """Check that a covariance is one."""
    xx, xy, _, yx, yy, _, _, _, aa = estimate.pose_covariance
    assert all(isfinite(value) for value in estimate.pose_covariance)
    assert min(xx, yy, aa) > 0 and abs(xy - yx) < 1e-12
    assert xx * yy >= xy * xy * (1 - 1e-6)


# What happens, in any order.


MODES = (oi.Mode.PASSIVE, oi.Mode.SAFE, oi.Mode.FULL)
SPEEDS = st.sampled_from((0.0, 0.05, 0.2, -0.3, 0.5, 9.0, nan, inf))
TURNS = st.sampled_from((0.0, 0.1, -1.0, 3.0, -20.0))
BODIES = {'ideal': IDEAL, 'centre': DEFAULT_BODY}
WORLDS = {
    'empty': World(),
    'dock': parse('home_base 0.5 0 180\nbox -1 -1 1 1\ncliff 0.5 0.5 0.9 0.5 0.9 0.9', 'dock')}
GOALS = {
    'short way': lambda: distance(0.2), 'way back': lambda: distance(-0.3, 0.1),
    'long way': lambda: distance(9.0, 0.5), 'no way': lambda: distance(0.0),
    'little time': lambda: distance(1.0, allowance=0.5), 'turn': lambda: angle(90),
    'arc': lambda: arc(120, 0.3), 'place': lambda: place(-0.3, 0.2, 90),
    'dock': lambda: Dock(20.0),
    'undock': lambda: Undock(0.0)}
TIMES = st.sampled_from((0.005, 0.02, 0.1, 0.3, 0.7, 1.5))
SHARES = st.sampled_from((0.05, 0.3, 1.0))
SCRIPT = build_script([
    oi.DriveDirect(right=100, left=100), oi.WaitTime(time=5), oi.DriveDirect(right=0, left=0)])


class Sequences(RuleBasedStateMachine):
    """Everything that can happen to a driver, in any order."""

    @initialize(body=st.sampled_from(sorted(BODIES)), acceleration=st.sampled_from((0.0, 0.5)),
                world=st.sampled_from(sorted(WORLDS)), goal=st.sampled_from(['', *sorted(GOALS)]))
    def begin(self, body, acceleration, world, goal):
        """Let driver and robot meet; begin with a goal, for what comes next to interrupt."""
        self.loop = WatchedLoop(BODIES[body], Settings(
            odometry_window=1.0,
            limits=MotionLimits(linear_acceleration=acceleration,
                                angular_acceleration=4 * acceleration)), WORLDS[world])
        self.loop.run(0.3)
        if goal:
            self.loop.pursue(GOALS[goal]())

    @property
    def driver(self):
        return self.loop.driver

    # Time and commands.

    @rule(seconds=TIMES)
    def wait(self, seconds):
        self.loop.run(seconds)

    @rule(linear=SPEEDS, angular=TURNS)
    def command(self, linear, angular):
        self.loop.command(linear, angular)
        self.loop.run(0.03)

    @rule(linear=SPEEDS, angular=TURNS, times=st.integers(2, 15))
    def drive(self, linear, angular, times):
        for _ in range(times):
            self.loop.command(linear, angular)
            self.loop.run(0.1)

    # Goals.

    @rule(goal=st.sampled_from(sorted(GOALS)), seconds=TIMES, ready=st.booleans())
    def pursue(self, goal, seconds, ready):
        if ready:
            self.make_ready()
        self.loop.pursue(GOALS[goal]())
        self.loop.run(seconds)

    @rule()
    def make_ready(self):
        """Let go of the robot, switch it on, and have it in Safe."""
        loop = self.loop
        loop.body.lift(False)
        loop.body.hold(right=False, left=False)
        loop.body.plug_charger(False)
        loop.body.unforce()
        loop.robot.power(True, loop.now)
        until = loop.now + 1.0
        while not self.driver.state.answered and loop.now < until:
            loop.turn()
        self.stop()
        self.set_mode(oi.Mode.SAFE)
        loop.run(0.1)

    @rule(number=st.sampled_from((-1, -1, -2)), gone=st.booleans())
    def end_goal(self, number, gone):
        """Cancel a goal, or let its client go; it may have ended, or another may run."""
        for each in self.loop.pursuits[number:][:1]:
            self.driver.goals.cancel(
                each.goal, self.loop.now, CLIENT_GONE if gone else CANCELED)

    @rule()
    def until_goal_ends(self):
        """Let a goal run, and let time pass."""
        until = self.loop.now + 3.0
        while self.driver.state.pursues and self.loop.now < until:
            self.loop.turn()

    # Requests.

    @rule(mode=st.sampled_from(MODES))
    def set_mode(self, mode):
        self.loop.request(self.driver.modes.set(mode, self.loop.now))

    @rule()
    def stop(self):
        self.loop.request(self.driver.stop(self.loop.now))
        self.loop.asked_at, self.loop.stopped = -inf, True
        self.loop.excuse(0.1)

    @rule(demo=st.sampled_from(oi.DemoNumber))
    def start_demo(self, demo):
        self.loop.request(self.driver.modes.start_demo(demo))

    @rule()
    def stop_demo(self):
        self.loop.request(self.driver.modes.stop_demo())

    @rule(number=st.integers(0, 15))
    def play_song(self, number):
        self.loop.request(self.driver.songs.define(number, [60, 64], [0.1, 0.2]))
        self.loop.request(self.driver.songs.play(number, self.loop.now))

    @rule(color=st.integers(0, 255))
    def light(self, color):
        self.loop.request(self.driver.outputs.set_leds(
            oi.Leds(bits=oi.LedBits.PLAY, color=color, intensity=128)))

    @rule(force=st.booleans())
    def play_script(self, force):
        self.loop.request(self.driver.scripts.define(SCRIPT))
        self.loop.request(self.driver.scripts.play(self.loop.now, force=force))

    @rule()
    def reset_odometry(self):
        self.loop.reset_odometry()

    # Hands on the robot.

    @rule(right=st.booleans(), left=st.booleans())
    def bump(self, right, left):
        self.loop.body.force(bump_right=right, bump_left=left, seconds=0.4)

    @rule(seconds=st.sampled_from((0.02, 0.5)))
    def cliff(self, seconds):
        self.loop.body.force(cliff_left=1, seconds=seconds)

    @rule(lifted=st.booleans())
    def lift(self, lifted):
        self.loop.body.lift(lifted)

    @rule(held=st.booleans())
    def hold(self, held):
        self.loop.body.hold(right=held, left=held)

    @rule(speed=st.sampled_from((0.1, -0.2)))
    def push(self, speed):
        self.loop.body.push(speed=speed, rate=0.3, seconds=0.5)

    @rule(plugged=st.booleans())
    def charger(self, plugged):
        self.loop.body.plug_charger(plugged)

    @rule(seconds=st.sampled_from((0.01, 1.0, 3.0)))
    def power_off_and_on(self, seconds):
        self.loop.robot.power(False, self.loop.now)
        self.loop.run(seconds)
        self.loop.robot.power(True, self.loop.now)

    # The line.

    @rule(seconds=st.sampled_from((0.02, 0.2, 1.2)))
    def cut(self, seconds):
        self.loop.lose_line(seconds)

    @rule(seconds=st.sampled_from((0.0, 0.2, 1.2)))
    def lose_port(self, seconds):
        self.driver.disconnected('the cable was pulled')
        self.loop.run(seconds)
        self.driver.connected(self.loop.now)

    @rule(share=SHARES, seconds=TIMES)
    def damage_what_comes(self, share, seconds):
        self.loop.damage_down = share
        self.loop.run(seconds)
        self.loop.damage_down = 0.0

    @rule(share=SHARES, seconds=TIMES)
    def damage_what_goes(self, share, seconds):
        self.loop.damage_up = share
        self.loop.run(seconds)
        self.loop.damage_up = 0.0

    @rule(tenths=st.sampled_from((3, 12)))
    def misheard(self, tenths):
        """Let the robot wait, as damaged bytes may tell it to."""
        self.loop.robot.receive(oi.WaitTime(time=tenths).encode(), self.loop.now)

    @rule(seconds=st.sampled_from((0.3, 2.0)))
    def stand_still(self, seconds):
        """Stop the driver's process for a while; the dead-man stops the robot."""
        self.loop.stand_still(seconds)

    def teardown(self):
        if not hasattr(self, 'loop'):
            return
        loop = self.loop
        loop.driver.shut_down(loop.now)
        loop.run(0.1)
        reached = loop.robot.powered and not loop.robot.waiting and loop.robot.demo is None
        if reached and loop.now > loop.excused_until:
            assert not any(loop.robot.actuators.wheels), 'wheels turn after the end'
        loop.driver.disconnected('closed')
        assert all(len(each.endings) == 1 for each in loop.pursuits), 'a goal ended not just once'
        assert all(len(got) == 1 for got in loop.replies), 'a reply was lost or given twice'


@pytest.mark.timeout(3600)
@pytest.mark.parametrize(('sequences', 'steps'), [
    (25, 40), pytest.param(times(250), 200, marks=NIGHTLY)])
def test_any_sequence_ends_well(sequences, steps):
    run_state_machine_as_test(Sequences, settings=settings(
        settings(), max_examples=sequences, stateful_step_count=steps,
        suppress_health_check=list(HealthCheck)))
