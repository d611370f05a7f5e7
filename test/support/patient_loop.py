# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The loop of `loop`, with a host that wants the robot's place only now and then."""

from math import inf
from random import Random
from typing import Any

from create_oi_ros.driver import Moved, Notice
from create_oi_ros.link.session import READ_TIMEOUT
from support.loop import Loop, STEP


class PatientLoop(Loop):
    """Calls the driver as `link.session` does: when bytes have come, or none for a while."""

    def __init__(self, patience: float, *, in_pieces: bool = False, **options: Any) -> None:
        """
        Want the robot's place every `patience` seconds; 0: of each frame.

        `in_pieces`: the end of what the robot sends comes a step later, as from some adapters.
        """
        super().__init__(**options)
        self.patience = patience
        self._pieces = Random(3) if in_pieces else None
        self.told: list[tuple[float, Moved | Notice]] = []
        """What happened, and when the host was told."""
        self.looks = 0
        """How often the host looked at frames."""
        self._due_at = -inf
        self._read_at = self.now
        self.kept = 0
        """Pieces of bytes that wait."""

    def turn(self) -> None:
        """Let one step of time pass."""
        self.now += STEP
        self.robot.poll(self.now)
        self._carry_down(self.robot.data_to_send())
        while (data := self._arrived(self._down)) is not None:
            self._read_at = self.now
            if self.driver.may_wait(data, self.now):
                self.kept += 1
            else:
                self.driver.receive(data, self.now)
                self._look()
        if self.now - self._read_at > READ_TIMEOUT:
            self._look()
        self._send()

    def _carry_down(self, data: bytes) -> None:
        if not data or self._pieces is None:
            self._carry(self._down, data)
            return
        place = self._pieces.randint(1, len(data))
        self._carry(self._down, data[:place])
        if data[place:]:
            self._down.append((self.now + STEP, data[place:]))

    def _look(self) -> None:
        self.looks, self.kept = self.looks + 1, 0
        self.report()
        self.driver.poll(self.now)
        self._send()
        self.report()

    def _send(self) -> None:
        self._carry(self._up, self.driver.data_to_send())
        while (data := self._arrived(self._up)) is not None:
            self.heard += data
            self.robot.receive(data, self.now)

    def report(self) -> None:
        """Tell the host what has happened."""
        while (event := self.driver.next_event()) is not None:
            if isinstance(event, Moved | Notice):
                self.told.append((self.now, event))
            if isinstance(event, Moved):
                self.moved.append(event)
                if self.patience and event.stamp >= self._due_at:
                    self._due_at = event.stamp + self.patience
                    self.driver.wait_until = self._due_at
