"""The whole driver against the whole simulated robot, as bytes over a line that delays them."""

from collections import deque
from math import degrees, hypot, tau
from random import Random

from create_oi_ros.driver import Driver, MotionLimits, Moved, Settings
from create_oi_ros.odometry import Estimate
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import BodyConfig
from create_oi_ros.sim.body.encoders import Rounding
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.world import World
from odometry_rig import HALF_TRACK, Instant, mixed, nees, Score, SLOT, spread, TOP_SPEED

STEP = SLOT / 3
COMMAND_EVERY = 0.1
"""Seconds from one cmd_vel to the next."""


class Line:
    """Bytes on their way, each piece late by its own time, none overtaking another."""

    def __init__(self, random: Random, latency: float) -> None:
        self._random, self._latency = random, latency
        self._pieces: deque[tuple[float, bytes]] = deque()
        self._last = 0.0

    def put(self, data: bytes, now: float) -> None:
        """Send bytes."""
        if data:
            self._last = max(self._last, now + self._random.uniform(0, self._latency))
            self._pieces.append((self._last, data))

    def take(self, now: float) -> bytes:
        """Return what has arrived."""
        arrived = bytearray()
        while self._pieces and self._pieces[0][0] <= now:
            arrived += self._pieces.popleft()[1]
        return bytes(arrived)


class Journey:
    """A driver, a robot, and what both say about where it is."""

    def __init__(self, seed: int, rounding: Rounding, latency: float, window: float) -> None:
        random = Random(seed)
        config = BodyConfig(
            wheel_acceleration=spread(random, 0.5, 2.0),
            right_speed_gain=random.uniform(0.97, 1.03),
            left_speed_gain=random.uniform(0.97, 1.03))
        self.body = Body(World(), rounding=rounding, config=config)
        self.robot = Create(self.body)
        limits = MotionLimits(timeout=2 * COMMAND_EVERY)
        self.driver = Driver(Settings(odometry_window=window, limits=limits))
        self.random = random
        self._up, self._down = Line(random, latency), Line(random, latency)
        self.now = 0.0
        self.estimate = Estimate()
        self.step = self.step_angle = self.turned = self.path = 0.0
        self.driver.connected(0.0)

    def go(self) -> None:
        """Let a step of time pass."""
        self.now += STEP
        before = self.body.truth()
        self.robot.poll(self.now)
        self._down.put(self.robot.data_to_send(), self.now)
        self.driver.receive(self._down.take(self.now), self.now)
        self.driver.poll(self.now)
        self._up.put(self.driver.data_to_send(), self.now)
        self.robot.receive(self._up.take(self.now), self.now)
        while (event := self.driver.next_event()) is not None:
            if isinstance(event, Moved):
                self._see(event.estimate)
        truth = self.body.truth()
        self.turned += abs(truth.turned - before.turned)
        self.path += abs(truth.travelled - before.travelled)

    def _see(self, estimate: Estimate) -> None:
        last, self.estimate = self.estimate, estimate
        self.step = max(self.step, hypot(estimate.x - last.x, estimate.y - last.y))
        self.step_angle = max(self.step_angle, abs(estimate.yaw - last.yaw))

    def score(self) -> Score:
        """Judge the estimate that stands at the end."""
        truth, e = self.body.truth(), self.estimate
        end = Instant(0, 0, 0, 0, True, False, truth.pose.x, truth.pose.y, truth.turned)
        reach = TOP_SPEED * SLOT
        return Score(
            degrees(abs(e.yaw - end.yaw)) / (self.turned / tau),
            100 * hypot(e.x - end.x, e.y - end.y) / self.path, nees(end, e),
            1000 * max(0.0, self.step - reach),
            degrees(max(0.0, self.step_angle - reach / HALF_TRACK)))


def travel(seed: int, rounding: Rounding, latency: float, window: float, seconds: float) -> Score:
    """Drive a while by cmd_vel, as a user does."""
    journey = Journey(seed, rounding, latency, window)
    speeds, spoken = (0.0, 0.0), 0.0
    for at, right, left in [*mixed(journey.random, seconds), (seconds, 0, 0)]:
        while journey.now < at:
            if journey.now >= spoken:
                journey.driver.drive(*speeds, journey.now)
                spoken += COMMAND_EVERY
            journey.go()
        speeds = (right + left) / 2000, (right - left) / 2000 / HALF_TRACK
        spoken = journey.now
    return journey.score()


