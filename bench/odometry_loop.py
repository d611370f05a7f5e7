# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The whole driver against the whole simulated robot, as bytes over a line that delays them."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from random import Random

from create_oi_ros.driver import Driver, Moved, Settings
from create_oi_ros.odometry import Estimate, GyroSettings, Knowledge, Odometry
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.mechanics import Truth
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import World
from drives import Wish
from rivals import Counts
from robots import Robot

TURNS = 3
"""Turns of the loop a slot."""
COMMAND_EVERY = 0.1
"""Seconds from one cmd_vel to the next of the same velocity."""
Damage = Callable[[bytes], bytes]


class Line:
    """Bytes on their way, each piece late by its own time, none overtaking another."""

    def __init__(self, random: Random, latency: float) -> None:
        self._random, self._latency = random, latency
        self._pieces: deque[tuple[float, float, bytes]] = deque()
        self._last = 0.0
        self.sent = 0.0
        """When the last piece was sent that has arrived."""

    def put(self, data: bytes, now: float) -> None:
        """Send bytes."""
        if data:
            self._last = max(self._last, now + self._random.uniform(0, self._latency))
            self._pieces.append((self._last, now, data))

    def take(self, now: float) -> bytes:
        """Return what has arrived."""
        arrived = bytearray()
        while self._pieces and self._pieces[0][0] <= now:
            _, self.sent, data = self._pieces.popleft()
            arrived += data
        return bytes(arrived)


class Journey:
    """A driver, a robot, and what both say about where it is."""

    def __init__(self, robot: Robot, seed: int, *, latency: float = 0.0, damage: Damage = bytes,
                 odometry: Odometry | None = None, gyro: GyroSettings | None = None,
                 known: Knowledge | None = None) -> None:
        self.body = Body(World(), rounding=robot.rounding, config=robot.config, seed=seed)
        self.robot = Create(self.body, guesses=Guesses(
            boot_seconds=0.0, banner=False, frame_period=robot.period))
        self.driver = Driver(
            Settings(geometry=robot.geometry, gyro=gyro, robot=known), odometry)
        self._damage = damage
        self._step = robot.period / TURNS
        random = Random(seed)
        self._up, self._down = Line(random, latency), Line(random, latency)
        self.now = 0.0
        self.estimate = Estimate()
        self.moves: list[tuple[float, Estimate, Truth]] = []
        """Each frame's estimate, with the truth when it arrived."""
        self._turned: dict[float, float] = {}
        """How far the robot had turned when it sent something: a frame tells of that moment."""
        self.event: Iterator[object] | None = None
        """What happens to the robot, slot by slot."""
        self.counts: list[Counts] = []
        """What the encoders had counted after each slot."""
        self.turned = 0.0
        self._steps = 0
        self.driver.connected(0.0)

    def go(self) -> None:
        """Let a step of time pass."""
        if self.event is not None and self._steps % TURNS == 0:
            next(self.event)
        self.now += self._step
        before = self.body.truth().turned
        self.robot.poll(self.now)
        if sent := self._damage(self.robot.data_to_send()):
            self._down.put(sent, self.now)
            self._turned[self.now] = self.body.truth().turned
        self.driver.receive(self._down.take(self.now), self.now)
        self.driver.poll(self.now)
        self._up.put(self.driver.data_to_send(), self.now)
        self.robot.receive(self._up.take(self.now), self.now)
        truth = self.body.truth()
        while (event := self.driver.next_event()) is not None:
            if isinstance(event, Moved):
                self.estimate = event.estimate
                self.moves.append((event.stamp, event.estimate, truth))
        self._steps += 1
        if self._steps % TURNS == 0:
            self.counts.append(Counts(self.body.distance_total, self.body.angle_total))
        self.turned += abs(truth.turned - before)

    def drive(self, wishes: Sequence[Wish], seconds: float) -> None:
        """Drive by cmd_vel, as a user does."""
        velocity, spoken = (0.0, 0.0), 0.0
        for at, linear, angular in [*wishes, (seconds, 0.0, 0.0)]:
            while self.now < at:
                if self.now >= spoken:
                    self.driver.drive(*velocity, self.now)
                    spoken = self.now + COMMAND_EVERY
                self.go()
            velocity, spoken = (linear, angular), self.now
