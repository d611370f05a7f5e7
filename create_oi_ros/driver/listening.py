# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Whether the robot listens, and who may send what while it may not.

The line to the robot has no checksum and no acknowledgement. A robot that is off, that waits, or
that is in the middle of a command takes nothing. What it is sent meanwhile is lost, in part even,
or is obeyed afterwards, until its queue is full. So the driver asks a question: for a list of
packets that is asked for nothing else. The first frame of that list is the answer. It is never
the list that the robot streams already, nor that of the question before, so no frame that is
still on its way is taken for the answer.

A question is open from when a robot is called; from when a script is sent to play; and from when
a robot shows no sign that it takes commands, such as another list that it was asked for, or the
speeds that it was sent. While a question is open,

- it is asked again: by each call, or ever more seldom;
- one stop that somebody asks for is sent to a robot whose frames come, and any number to one that
  is called (`may_stop`);
- the driver sends nothing of its own (`may_send`): no lists, modes, songs, LEDs or restart, and
  no speeds but one zero. None of what it sends can do harm where a part of it is lost;
- requests are refused where it is certain that the robot does not listen (`Core.refusal`).
"""

from collections.abc import Callable, Iterable
from enum import IntEnum
from math import inf

from .. import oi
from .events import Severity
from .outbox import HALT, Outbox, WAKE_UP

QUESTIONS = tuple(oi.PacketList([name]) for name in ('infrared', 'buttons', 'virtual_wall'))
"""The usual ones. No part of a Stream of these can do harm, not even read at another rate, where
that of the mode restarts the robot or starts Cover."""
ASK_INTERVAL, ASK_FRACTION = 0.2, 0.2
"""Seconds between two times that a question is asked; at least this part of the time for which it
is open, so that a long wait gets few."""
IGNORES = ('the robot ignores commands, even a stop: damaged bytes may have told it to wait; '
           'lift it, switch it off and on')


class Doubt(IntEnum):
    """What the driver does as long as the robot shows no sign that it takes commands."""

    NONE = 0
    HOLD_BACK = 1
    """Open a question: the robot may wait, or be in the middle of a command."""
    WAKE = 2
    """Send what ends a command that was cut short."""
    REPORT = 3
    """Tell the user."""


DOUBT_TIMES = (0.3, 0.9, 1.5)
"""Seconds without a sign after which each of these begins."""


class Listening:
    """The open question, and the doubt that opens one."""

    def __init__(self, outbox: Outbox, notice: Callable[[Severity, str], None]) -> None:
        self._outbox, self._notice = outbox, notice
        self._list = self._newest = oi.PacketList([])
        """What the question asks for, and what the newest frame brought."""
        self.open = False
        """Whether a question waits for its answer."""
        self._asked = False
        """Whether it was asked: until then a frame of its list is late."""
        self._since = self._due = inf
        """From when on it is asked ever more seldom, and when it is asked next."""
        self._stops = False
        """Whether a stop goes before it when it is asked first."""
        self.stop_sent = False
        """Whether a stop that somebody asked for was sent since it is open."""
        self.trust()

    def trust(self) -> None:
        """Start anew: the robot was away, takes commands, or cannot take them now."""
        self._streamed: oi.PacketList | None = None
        """The newest list that frames brought and that is no question."""
        self.unseen_since: float | None = None
        """When the robot was asked for another list that no frame has shown yet."""
        self.doubt = Doubt.NONE

    # Questions.

    def begin(self, due: float = inf, lists: Iterable[oi.PacketList] = QUESTIONS, *,
              after_script: float | None = None) -> None:
        """
        Open a question for one of some lists; `poll` asks it from `due` on.

        `after_script`: when the script should have ended that plays now. Then the question is
        asked once with a stop before it, for a robot that keeps what it is sent, and again from
        that moment on.
        """
        self._list = next((each for each in lists if each not in (self._list, self._newest)),
                          self._list)
        self.open, self._asked, self.stop_sent = True, False, False
        self._due, self._stops = due, after_script is not None
        self._since = due if after_script is None else after_script

    def ask(self) -> None:
        """Ask the question; it is open again where its answer led to nothing."""
        self.open = self._asked = True
        self._outbox.send(oi.Stream(packets=self._list.ids))

    def answered(self, packets: oi.PacketList) -> bool:
        """
        Tell whether a frame of this list answers the question, which is closed then.

        Where a list changes that is no question, the robot took a command, too.
        """
        answers = self.open and self._asked and packets == self._list
        if answers:
            self.open = False
            self.trust()
        self._newest = packets
        if packets not in QUESTIONS and packets != self._streamed:
            self._streamed, self.unseen_since = packets, None
        return answers

    def poll(self, now: float) -> None:
        """Ask the open question again, when it is time."""
        if self.open and now >= self._due and not self._outbox.busy:
            if self._stops:
                self._outbox.send(HALT)
                self._stops = False
            self.ask()
            self._due = max(
                self._since, now + max(ASK_INTERVAL, ASK_FRACTION * (now - self._since)))

    def close(self) -> None:
        """Close the question without an answer: something else shows that the robot listens."""
        self.open = False

    # Who may send what.

    @property
    def may_send(self) -> bool:
        """Whether the driver may send anything of its own."""
        return not self.open

    @property
    def may_stop(self) -> bool:
        """Whether a stop that somebody asks for is sent; `stop_sent` notes that it was."""
        called = self._due == inf
        return not self.open or called or not self.stop_sent

    # Doubt.

    @property
    def ignores(self) -> bool:
        """Whether the robot ignores commands, and the user was told."""
        return self.doubt is Doubt.REPORT

    def asked(self, packets: oi.PacketList, now: float) -> None:
        """Note that the robot was asked for frames with these packets."""
        if self.unseen_since is None and self._streamed not in (None, packets):
            self.unseen_since = now

    def check(self, missed_since: float | None, now: float) -> bool:
        """
        Doubt a robot without a sign; True when it has just shown that it takes commands.

        `missed_since`: when speeds were sent that the robot has not taken; None: it took all.
        """
        before = self.doubt
        times = [since for since in (missed_since, self.unseen_since) if since is not None]
        if not times:
            self.doubt = Doubt.NONE
            self.open = self.open and not before
            return bool(before)
        waits = now - min(times)
        self.doubt = max(before, Doubt(sum(waits > limit for limit in DOUBT_TIMES)))
        if self.doubt > before:
            if not before:
                self.begin(now)
            if self.doubt is Doubt.WAKE:
                self._outbox.send_raw(WAKE_UP)
            elif self.ignores:
                self._notice(Severity.ERROR, IGNORES)
        return False
