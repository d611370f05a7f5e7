# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The outcome of a request: known at once, or when the robot has taken it or answered."""

from collections.abc import Callable
from typing import NamedTuple


class Outcome(NamedTuple):
    """How a request ended."""

    ok: bool
    text: str
    """For people: what was done; or why it was not done, and what to do."""
    payload: bytes = b''
    """The bytes that were asked for: a script."""


class Pending:
    """A request whose outcome may not be known yet. Only the first outcome counts."""

    __slots__ = ('outcome', '_callbacks')

    def __init__(self) -> None:
        self.outcome: Outcome | None = None
        """None until the request has ended."""
        self._callbacks: list[Callable[[Outcome], None]] = []

    def end(self, ok: bool, text: str, payload: bytes = b'') -> None:
        """End the request."""
        if self.outcome is None:
            self.outcome = Outcome(ok, text, payload)
            for callback in self._callbacks:
                callback(self.outcome)
            self._callbacks.clear()

    def then(self, callback: Callable[[Outcome], None]) -> None:
        """Call back with the outcome: now if it is known, else as soon as it is."""
        if self.outcome is None:
            self._callbacks.append(callback)
        else:
            callback(self.outcome)


def done(text: str) -> Pending:
    """Return a request that has succeeded."""
    pending = Pending()
    pending.end(True, text)
    return pending


def refused(text: str) -> Pending:
    """Return a request that is refused; the text says why, and what to do."""
    pending = Pending()
    pending.end(False, text)
    return pending
