"""
What is asked for by service: checked before it is sent, answered when it is written.

A command that the robot would ignore, for its mode or for lack of a robot, is refused in words
that say what to do.
"""

from collections.abc import Callable
from typing import NamedTuple

from .. import oi
from .outbox import Outbox

Reply = Callable[[bool, str], None]
"""Takes whether a request succeeded, and if not why and what to do."""
LOST = 'the robot was lost before the command was written: try again when it answers'


def mode_refusal(command: type[oi.Command], mode: oi.Mode | None) -> str:
    """Say why the robot would not obey a command in a mode, and what to do; '' if it would."""
    if mode is None:
        return 'no robot answers: check cable and power, the driver keeps trying'
    if mode in command.modes:
        return ''
    return f'robot is in {mode.name}: call set_mode with SAFE first'


class Requests:
    """Sends commands that somebody waits for."""

    def __init__(self, outbox: Outbox, refusal: Callable[[type[oi.Command]], str]) -> None:
        """Take where commands go, and what says why a kind of command cannot be sent now."""
        self._outbox = outbox
        self.refusal = refusal

    def send(
        self, command: oi.Command, reply: Reply, done: str, *, pause: float = 0.0,
    ) -> bool:
        """Send a command, or refuse it; `done` is said when it is written. Tells if it is sent."""
        refusal = self.refusal(type(command))
        if refusal:
            reply(False, refusal)
            return False

        def told(written: bool) -> None:
            reply(written, done if written else LOST)
        try:
            self._outbox.send(command, pause=pause, told=told)
        except ValueError as error:
            reply(False, str(error))
            return False
        return True


class _Awaited(NamedTuple):
    mode: oi.Mode
    deadline: float
    reply: Reply


class ModeRequest:
    """The mode that somebody waits for the robot to report."""

    def __init__(self) -> None:
        self._awaited: _Awaited | None = None

    def begin(self, mode: oi.Mode, deadline: float, reply: Reply) -> None:
        """Wait for a mode until a time; whoever waited before is told that he waits in vain."""
        self.answer(False, 'another request came before the robot answered')
        self._awaited = _Awaited(mode, deadline, reply)

    def expired(self, now: float) -> oi.Mode | None:
        """Return the mode that has been waited for too long."""
        awaited = self._awaited
        return awaited.mode if awaited is not None and now > awaited.deadline else None

    def observe(self, actual: oi.Mode | None) -> None:
        """Answer if this is the mode that is waited for."""
        if self._awaited is not None and actual == self._awaited.mode:
            self.answer(True, f'robot is in {self._awaited.mode.name}')

    def answer(self, success: bool, message: str) -> None:
        """Answer, if somebody waits."""
        awaited, self._awaited = self._awaited, None
        if awaited is not None:
            awaited.reply(success, message)
