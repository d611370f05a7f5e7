# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The outcome of a request: known at once, or when the robot has taken it or answered."""

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar


class Outcome(NamedTuple):
    """How a request ended."""

    ok: bool
    text: str
    """For people: what was done; or why it was not done, and what to do."""
    payload: bytes = b''
    """The bytes that were asked for: a script."""


Result = TypeVar('Result')


class Awaited(Generic[Result]):
    """A result that may not be known yet. Only the first one counts."""

    __slots__ = ('result', '_callbacks')

    def __init__(self) -> None:
        self.result: Result | None = None
        """None until it is known."""
        self._callbacks: list[Callable[[Result], None]] = []

    def settle(self, result: Result) -> None:
        """Say what the result is."""
        if self.result is None:
            self.result = result
            for callback in self._callbacks:
                callback(result)
            self._callbacks.clear()

    def then(self, callback: Callable[[Result], None]) -> None:
        """Call back with the result: now if it is known, else as soon as it is."""
        if self.result is None:
            self._callbacks.append(callback)
        else:
            callback(self.result)


class Pending(Awaited[Outcome]):
    """A request whose outcome may not be known yet."""

    __slots__ = ()

    @property
    def outcome(self) -> Outcome | None:
        """How it ended; None until it has."""
        return self.result

    def end(self, ok: bool, text: str, payload: bytes = b'') -> None:
        """End the request."""
        self.settle(Outcome(ok, text, payload))


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
