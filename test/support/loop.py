# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The driver and the simulated robot in memory, without clock or thread: hours in seconds."""

from collections import deque
from dataclasses import replace
from math import pi

from create_oi_ros import oi
from create_oi_ros.driver import Driver, MotionLimits, Moved, Notice, Settings, Severity
from create_oi_ros.odometry import Estimate, Odometry
from create_oi_ros.robot import Rounding, WHEEL_SEPARATION
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import BodyConfig, IDEAL
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.world import shipped, World

STEP = 0.005
"""Seconds between two turns of the loop: a third of a slot."""
AT_ONCE = MotionLimits(linear_acceleration=0.0, angular_acceleration=0.0)
"""No limit of acceleration: the wheels are sent each command as it is."""


class Loop:
    """One robot, one driver, and a line with a delay between them."""

    def __init__(
        self, settings: Settings | None = None, *, world: World | None = None, delay: float = 0.0,
        rounding: Rounding = Rounding.CARRY, checksum: oi.Checksum = oi.Checksum.HARDWARE,
        robot_baud: int | None = None, wheel_separation: float = WHEEL_SEPARATION,
        config: BodyConfig | None = None, odometry: Odometry | None = None,
    ) -> None:
        """`robot_baud` sets the robot's own baud rate; without it, it is always the driver's."""
        self.body = Body(
            world or shipped('empty'), rounding=rounding,
            config=config or replace(IDEAL, wheel_separation=wheel_separation))
        self.robot = Create(self.body, checksum=checksum)
        self.driver = Driver(settings or Settings(), odometry)
        self.now = 100.0
        self.delay = delay
        self.cut = self.lost_down = False
        """Whether the line carries nothing, or nothing that the robot sends."""
        self.forged: dict[str, int] = {}
        """Values that replace the robot's own in its frames, by packet."""
        self.heard = bytearray()
        """All bytes that the robot has received since the last call of `commands`."""
        self.notices: list[Notice] = []
        self.moved: list[Moved] = []
        self._up: deque[tuple[float, bytes]] = deque()
        self._down: deque[tuple[float, bytes]] = deque()
        self._has_rate = robot_baud is not None
        if robot_baud is not None:
            code = oi.BaudCode[f'B{robot_baud}']
            self.robot.receive(oi.Start().encode() + oi.Baud(code=code).encode(), self.now - 1)
        self.driver.connected(self.now)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        until = self.now + seconds
        while self.now < until - STEP / 2:
            self.turn()

    def turn(self) -> None:
        """Let one step of time pass."""
        self.now += STEP
        self.robot.host_baud(self.driver.baud if self._has_rate else None)
        self.robot.poll(self.now)
        self._carry(self._down, self._forge(self.robot.data_to_send()))
        while (data := self._arrived(self._down)) is not None:
            self.driver.receive(data, self.now)
        self.driver.poll(self.now)
        self._carry(self._up, self.driver.data_to_send())
        while (data := self._arrived(self._up)) is not None:
            self.heard += data
            self.robot.receive(data, self.now, self.driver.baud if self._has_rate else None)
        while (event := self.driver.next_event()) is not None:
            match event:
                case Moved():
                    self.moved.append(event)
                case Notice():
                    self.notices.append(event)

    def drive(self, linear: float, angular: float, seconds: float) -> None:
        """Command a velocity ten times a second for a while."""
        until = self.now + seconds
        while self.now < until - STEP / 2:
            self.driver.drive(linear, angular, self.now)
            self.run(min(0.1, until - self.now))

    def lose_line(self, seconds: float) -> None:
        """Let the line carry nothing for a while."""
        self.cut = True
        self.run(seconds)
        self.cut = False

    def stand_still(self, seconds: float) -> None:
        """Let the robot send for a while, and call the driver no more."""
        until = self.now + seconds
        while self.now < until - STEP / 2:
            self.now += STEP
            self.robot.poll(self.now)

    def lose_port(self, seconds: float) -> None:
        """Lose the port for a while, and what either side sends meanwhile."""
        self.driver.disconnected('cable out')
        self.driver.data_to_send()
        self.stand_still(seconds)
        self.robot.data_to_send()
        self.driver.connected(self.now)

    @property
    def estimate(self) -> Estimate:
        """The newest estimate of the driver."""
        return self.moved[-1].estimate

    def commands(self) -> list[oi.Command]:
        """Return the commands that the robot has received since the last call."""
        reader = oi.CommandReader()
        reader.feed(bytes(self.heard))
        self.heard.clear()
        commands = []
        while (event := reader.next_event()) is not None:
            if isinstance(event, oi.Command):
                commands.append(event)
        return commands

    def _forge(self, data: bytes) -> bytes:
        if not self.forged or not data:
            return data
        reader = oi.StreamReader(self.driver.plan.lists)
        reader.feed(data)
        pieces = []
        for event in reader.finish():
            if isinstance(event, oi.Frame):
                came = event.readings
                event = event._replace(data=event.packets.pack_frame(
                    [self.forged.get(name, came.number(name, 0)) for name in event.packets.names],
                    header_in_sum=event.checksum is oi.Checksum.HARDWARE))
            pieces.append(event.data)
        return b''.join(pieces)

    def _carry(self, line: deque[tuple[float, bytes]], data: bytes) -> None:
        if data and not (self.cut or self.lost_down and line is self._down):
            line.append((self.now + self.delay, data))

    def _arrived(self, line: deque[tuple[float, bytes]]) -> bytes | None:
        if line and line[0][0] <= self.now:
            return line.popleft()[1]
        return None


def turn_difference(one: float, other: float) -> float:
    """Return the angle between two headings, rad."""
    return abs((one - other + pi) % (2 * pi) - pi)


def texts(notices: list[Notice], severity: Severity) -> list[str]:
    """Return what was said at a severity."""
    return [notice.text for notice in notices if notice.severity is severity]


def said(loop: Loop, severity: Severity, words: str) -> int:
    """Count the notices of a severity that hold some words."""
    return sum(words in notice.text for notice in loop.notices if notice.severity is severity)
