"""
Whether the robot hears what it is told.

The line towards the robot has no checksum and no acknowledgement, and a Wait (a damaged byte may
become one) makes the robot deaf while its stream goes on. What it must do when it hears is seen:
it streams another list of packets when it is asked to, and reports the speeds that it was sent.
"""

from enum import auto, Enum

from ..oi import SLOT

MISSES_DOUBTED, MISSES_TOLD = 4, 14
"""Speeds in a row that the robot missed: 0.6 s and 2 s of them."""
UNSEEN_DOUBTED, UNSEEN_TOLD = 0.6, 1.5
"""Seconds for which a list was asked for in vain."""
DEAF = ('the robot does not do what it is told, not even stop: damaged bytes may have told it to '
        'wait; lift it, switch it off and on')


class Turn(Enum):
    """What is new about the robot's hearing."""

    DOUBTED = auto()
    """It may be in the middle of a command."""
    DEAF = auto()
    HEARS_AGAIN = auto()


class Hearing:
    """Compares what the robot does with what it was asked for."""

    def __init__(self) -> None:
        self._list: tuple[int, ...] | None = None
        """The packets of the newest frame."""
        self._unseen_since: float | None = None
        self._last: Turn | None = None

    @property
    def deaf(self) -> bool:
        """Whether the user has reason to be told."""
        return self._last is Turn.DEAF

    def restart(self) -> None:
        """Forget all: the robot was away, or is not expected to hear."""
        self._list = self._unseen_since = self._last = None

    def asked(self, packets: tuple[int, ...], now: float) -> None:
        """Note that the robot was asked for frames with these packets."""
        if self._unseen_since is None and self._list not in (None, packets):
            self._unseen_since = now

    def seen(self, packets: tuple[int, ...]) -> None:
        """Note the packets of a frame; where they change, the robot has heard."""
        if packets != self._list:
            self._list, self._unseen_since = packets, None

    def turn(self, missed: int, now: float) -> Turn | None:
        """Judge, `missed` being how many speeds in a row the robot did not take; what is new."""
        unseen = 0.0 if self._unseen_since is None else now - self._unseen_since
        before = self._last
        if missed >= MISSES_TOLD or unseen > UNSEEN_TOLD:
            self._last = Turn.DEAF
        elif before is not Turn.DEAF and (missed >= MISSES_DOUBTED or unseen > UNSEEN_DOUBTED):
            self._last = Turn.DOUBTED
        elif not missed and unseen <= 2 * SLOT:
            self._last = None
        if self._last is before:
            return None
        return self._last or Turn.HEARS_AGAIN
