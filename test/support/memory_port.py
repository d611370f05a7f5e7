# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A serial port with a simulated robot in memory; time passes only while a program waits."""

from create_oi_ros.sim.firmware import Create

STEP = 0.005
"""Seconds that pass at once: a third of a slot."""


class MemoryPort:
    """What `serial.Serial` has, and what `time` has."""

    def __init__(self, create: Create, timeout: float = 1.0) -> None:
        self._create, self._timeout = create, timeout
        self._received = b''
        self._now = 0.0
        create.poll(0.0)

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        until = self._now + seconds
        while self._now < until - STEP / 2:
            self._now += STEP
            self._create.poll(self._now)
            self._received += self._create.data_to_send()

    def monotonic(self) -> float:
        """Return the time."""
        return self._now

    def write(self, data: bytes) -> None:
        """Send bytes to the robot."""
        self._create.receive(data, self._now)
        self._received += self._create.data_to_send()

    def read(self, size: int) -> bytes:
        """Wait for bytes; return fewer after the timeout."""
        until = self._now + self._timeout
        while len(self._received) < size and self._now < until:
            self.sleep(STEP)
        read, self._received = self._received[:size], self._received[size:]
        return read

    @property
    def in_waiting(self) -> int:
        """The number of bytes that have arrived."""
        return len(self._received)

    def reset_input_buffer(self) -> None:
        """Forget what has arrived."""
        self._received = b''
