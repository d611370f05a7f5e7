# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulated Create in memory and a host; `run` lets time pass."""

from typing import Any

from create_oi_ros import oi
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import BodyConfig, IDEAL
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import DEFAULT_GUESSES, Guesses
from create_oi_ros.sim.world import World

MODES = {oi.Mode.PASSIVE: oi.Start(), oi.Mode.SAFE: oi.Safe(), oi.Mode.FULL: oi.Full()}
GENTLE = oi.DriveDirect(right=100, left=100)


class Robot:
    """One robot, switched on long ago. Seconds since the start of the test."""

    def __init__(self, mode: oi.Mode = oi.Mode.OFF, *, world: World | None = None,
                 guesses: Guesses = DEFAULT_GUESSES, rounding: Rounding = Rounding.CARRY,
                 checksum: oi.Checksum = oi.Checksum.HARDWARE, seed: int = 0,
                 config: BodyConfig = IDEAL) -> None:
        self.body = Body(world or World(), rounding=rounding, seed=seed, config=config)
        self.create = Create(self.body, checksum=checksum, guesses=guesses, seed=seed)
        self.now = 0.0
        self.create.poll(0.0)
        if mode is not oi.Mode.OFF:
            self.say(oi.Start(), MODES[mode])
            assert self.create.mode is mode

    def say(self, *parts: oi.Command | bytes, baud: int | None = None) -> bytes:
        """Send commands or bytes; return the immediate reply."""
        data = b''.join(part if isinstance(part, bytes) else part.encode() for part in parts)
        self.create.receive(data, self.now, baud)
        return self.create.data_to_send()

    def run(self, seconds: float) -> bytes:
        """Let time pass; return the bytes that the robot sent."""
        self.now += seconds
        self.create.poll(self.now)
        return self.create.data_to_send()

    def slots(self, count: int = 1) -> bytes:
        """Let slots of 15 ms pass."""
        return self.run(count * oi.SLOT)

    def ask(self, *packets: int) -> bytes:
        """Return the reply to a Query List."""
        return self.say(bytes([149, len(packets), *packets]))

    def read(self, name: str) -> Any:
        """Return the value of a packet by its name in `Readings`."""
        packets = oi.PacketList([name])
        return getattr(packets.unpack_reply(self.ask(*packets.ids)), name)

    @property
    def mode(self) -> oi.Mode:
        """The mode, without asking for it."""
        return self.create.mode

    @property
    def wheels(self) -> tuple[float, float]:
        """Commanded wheel speeds: right, left, mm/s."""
        return tuple(self.create.actuators.wheels)

    @property
    def speed(self) -> float:
        """The true speed, m/s."""
        return self.body.truth().speed
