# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Finds the robot on an open port, and notices when the line stops carrying what it should.

The driver calls until frames come, and calls again when they stop, when the process itself stood
still, or when the port was opened again.
"""

from collections.abc import Callable
from math import inf

from .. import oi
from ..oi.codes import START_BAUDS
from .baud_search import ANSWER_TIME, BaudSearch, CALL_INTERVAL
from .command_watch import CommandNews, CommandWatch, IGNORES, Probe
from .events import EventQueue, LinkCounts, Severity
from .frame_budget import FrameBudget, too_slow
from .outbox import Outbox
from .state import Activity, State, StateEvent
from .stopping import HALT, WAKE_UP
from .stream_plan import StreamPlan

SILENCE = 0.5
"""Seconds without a frame after which the robot is called again."""
MOST_ABSENCE = 2.0
"""Seconds without a frame after which a robot was away: only then is it called by Start, which
changes its mode, and commands must pause before it follows them again."""
STANDSTILL = 1.0
"""Seconds between two calls of the driver after which its process must have been stopped."""
WAKE_UP_FIRST, WAKE_UP_EVERY = 3, 10
"""Calls of a robot that has fallen silent among which these end a command that was cut short: the
others leave room in the queue of a robot that only waits."""
STALE = 0.05
"""Seconds after a standstill in which the system still delivers old bytes."""


class Connection:
    """The line to the robot: whether it answers, at which rate, and how well."""

    def __init__(
        self, baud: int, state: State, outbox: Outbox, events: EventQueue, counts: LinkCounts,
        handle: Callable[[StateEvent], None],
    ) -> None:
        """`handle` passes an event to the driver's state."""
        self._state = state
        self._outbox = outbox
        self._events = events
        self._counts = counts
        self._handle = handle
        self._search = BaudSearch(baud)
        self._watch = CommandWatch()
        self._probe = Probe(outbox)
        self.frame_budget = FrameBudget()
        self.plan = StreamPlan(self._search.baud)
        self.reader = oi.StreamReader(self.plan.lists)
        self.heard_at = 0.0
        """When the last frame came, in the clock of `now`."""
        self.present_at = inf
        """When a frame came last; before the first one, when the robot was called first."""
        self._call_interval = CALL_INTERVAL
        self._ran_at = inf
        """When the driver was called last; in no past before the port is open."""
        self._stale_until = -inf
        self._slow_notice: str | None = None
        self._silence: str | None = None
        """What the user was told when the robot fell silent; None before."""

    @property
    def baud(self) -> int:
        """Bits per second of the next bytes; the port has to follow."""
        return self._search.baud

    @property
    def problem(self) -> str | None:
        """What the user was told of the line; None while nothing is wrong with it."""
        if self._state.answered:
            return self.frame_budget.problem
        return self._search.problem or self._silence

    @property
    def ignores_commands(self) -> bool:
        """Whether the robot ignores commands, and the user was told."""
        return self._watch.ignores

    @property
    def suspects(self) -> bool:
        """Whether the robot may not take commands: it is sent next to nothing then."""
        return self._watch.suspects

    def opened(self, now: float) -> None:
        """Start to call: the port has been opened."""
        self.present_at = min(self.present_at, now)
        self._search.restart()
        self._silence = None
        self._ran_at = now
        self._check_rate()
        self._call(now, StateEvent.OPENED)

    def was_away(self, now: float) -> bool:
        """Tell whether a robot that is heard now was not for so long that anything may be true."""
        return now - self.present_at > MOST_ABSENCE

    def forget(self) -> None:
        """Forget how well the line works: no robot answers."""
        self.plan.restart()
        self._watch.restart()
        self.frame_budget.restart()

    def feed(self, data: bytes, now: float) -> bool:
        """Take bytes in; False where they are too old to be used."""
        if now < self._stale_until:
            return False
        self.frame_budget.add_bytes(len(data))
        self.reader.feed(data)
        return True

    def add_frame(self, packets: oi.PacketList) -> None:
        """Note a verified frame."""
        self.frame_budget.add_frame(packets.frame_size)
        self._watch.seen(packets.ids)

    def add_garbage(self, garbage: bytes) -> None:
        """Note bytes that are no frame."""
        self._counts.garbage_bytes += len(garbage)
        self._search.add_garbage(garbage)

    def answered(self, event: StateEvent) -> None:
        """Note that the first frame has come; `event` is ANSWERED or RETURNED."""
        slow = self._search.raised_from
        if slow is not None:
            self._events.notice(Severity.WARNING, (
                f'the robot was at {slow} baud, too slow for its stream: it is at {self.baud} '
                'now, until it is switched off'))
        self._handle(event)
        self._check_rate()

    def ask(self, stream: oi.Stream, now: float) -> None:
        """Ask for another list of packets."""
        self._outbox.send(stream)
        self._watch.asked(tuple(stream.packets), now)

    def check_silence(self, now: float) -> None:
        """Call the robot when no frame has come for too long."""
        answered = self._state.answered
        if now - self.heard_at <= (SILENCE if answered else self._call_interval):
            return
        if answered:
            self._counts.silences += 1
            self._search.restart()
            why = self.frame_budget.why_silent(self.plan.budget, self.baud)
            self._silence = f'no frame for {SILENCE} s: {why}; calling it until it answers'
            self._events.notice(Severity.ERROR, self._silence)
        rest = self.reader.flush()
        if rest is not None:
            self._search.add_garbage(rest.data)
        notice = self._search.notice()
        if notice is not None:
            self._events.append(notice)
        self._call(now, StateEvent.NO_ANSWER)

    def check_standstill(self, now: float) -> None:
        """Call the robot again after this process stood still: the dead-man may have acted."""
        before, self._ran_at = self._ran_at, now
        if now - before > STANDSTILL and self._state.answered:
            self._stood_still(now - before, now)

    def _stood_still(self, seconds: float, now: float) -> None:
        self._events.notice(
            Severity.WARNING, f'the driver stood still for {seconds:.1f} s (Ctrl-Z, a debugger, a '
            'computer that slept or was too busy); calling the robot again')
        self._outbox.clear(HALT)
        self.reader.flush()
        self._search.restart()
        self._handle(StateEvent.NO_ANSWER)
        # Old bytes are dropped first: an answer among them would be lost, with its distance.
        self._stale_until = now + STALE
        self.heard_at = self._stale_until - self._call_interval

    def check_line(self, missed_since: float | None, now: float) -> bool:
        """
        React to a robot that ignores commands, and report a line that carries too little.

        True when the robot obeys again: then what it may have missed must be sent again.
        """
        if not self._state.takes_commands:
            self._watch.restart()
            self.frame_budget.restart()
            return False
        news = self._watch.check(missed_since, now)
        if news is CommandNews.SUSPECT:
            self._probe.begin(now)
        elif news is CommandNews.WAKE:
            self._outbox.send_raw(WAKE_UP)
        elif news is CommandNews.IGNORES:
            self._events.notice(Severity.ERROR, IGNORES)
        if now >= self.frame_budget.check_at and self.frame_budget.check(
                self.baud, now, fits=self.plan.budget.fits):
            problem = self.frame_budget.problem
            self._events.notice(Severity.WARNING if problem else Severity.INFO,
                                problem or 'frames arrive in time again')
        return news is CommandNews.OBEYS_AGAIN

    def probe(self, now: float) -> bool:
        """Poll a robot that may not take commands; True when it has just shown that it does."""
        if not self._watch.suspects or now < self._probe.due or self._outbox.busy:
            return False
        listens = self._probe.poll(now, self.heard_at)
        if listens:
            self._watch.restart()
            self.plan.restart()
        return listens

    def _call(self, now: float, event: StateEvent) -> None:
        """Stop the robot and start its stream, whatever it was doing before."""
        self._outbox.clear()
        self._handle(event)
        assert self._state.activity is Activity.CALLING
        self.heard_at = now
        baud = self._search.next_baud()
        ask: oi.Command = oi.Stream(packets=self.plan.knock.ids)
        if self._search.raises:
            ask = oi.Baud(code=oi.BaudCode.of_rate(START_BAUDS[0]))
        elif baud != self.plan.baud:
            self.plan.tune(baud)
            self.reader.expect(self.plan.lists)
        start = [] if self._counts.frames and not self.was_away(now) else [oi.Start()]
        stop = self._stop(event, baud)
        size = len(stop) + sum(len(each.encode()) for each in (*start, ask))
        self._call_interval = max(CALL_INTERVAL, ANSWER_TIME + (
            size + self.plan.full.frame_size) * oi.BITS_PER_BYTE / baud)
        self._outbox.send_raw(stop)
        for each in (*start, ask):
            self._outbox.send(each)

    def _stop(self, event: StateEvent, baud: int) -> bytes:
        """Return what a call begins with: next to nothing for a robot that may only wait."""
        calls = self._search.calls
        if (event is StateEvent.OPENED or self._search.searching
                or calls % WAKE_UP_EVERY == WAKE_UP_FIRST):
            # What has not left would delay a stop, or go out at the next rate.
            seconds = len(WAKE_UP) * oi.BITS_PER_BYTE / baud
            return WAKE_UP if seconds < CALL_INTERVAL else 2 * HALT.encode()
        return HALT.encode() if calls == 1 else b''

    def heard_knock(self, now: float) -> None:
        """Stop a robot that has answered a call, and ask it for all packets."""
        stream = None if self._state.answered else self.plan.next_stream(now, motion_due=True)
        if stream is not None:
            self.heard_at = now
            self._outbox.send(HALT)
            self._outbox.send(stream)

    def _check_rate(self) -> None:
        slow = too_slow(self.plan.budget, self.plan.baud)
        if slow is not None and slow != self._slow_notice:
            self._events.notice(Severity.ERROR, slow)
        self._slow_notice = slow
