# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Finds the robot on an open port, and notices when the line stops carrying what it should.

The driver calls until frames come, and calls again when they stop, when the process itself stood
still, or when the port was opened again. The robot may be off, in the middle of a command that
another program left unfinished, driving, or at another baud rate (that of Baud holds until power
is cycled).
"""

from itertools import cycle
from math import inf

from .. import oi
from ..oi.codes import FAST_BAUD, START_BAUDS
from ..robot import MILLI, SLOT
from .core import Core
from .events import LinkCounts, Severity
from .outbox import HALT, WAKE_UP
from .state import Activity, StateEvent
from .stream import Escalation, IGNORES, POLL_INTERVAL, Probe, StreamPlan

CALL_INTERVAL = 0.3
"""Seconds between two calls; more at rates where a call and its answer take longer."""
ANSWER_TIME = 0.1
"""Seconds from the end of a call to its answer."""
RATES = (*START_BAUDS, FAST_BAUD)
"""Bits per second at which a robot is looked for whose rate is not known."""
TRIED = ', '.join(map(str, RATES))
GARBAGE_LIMIT = 64
"""Bytes without a frame after which something else must be on the line."""
CALLS_BEFORE_NOTICE = 3
"""Calls without an answer before the user is told; a robot that boots misses one or two."""


class BaudSearch:
    """Counts calls, and picks the baud rate of the next one."""

    def __init__(self, baud: int) -> None:
        """Call at one rate; 0 searches for the robot's."""
        self.searching = baud == 0
        """Whether the robot's rate is not known."""
        self.baud = baud or RATES[0]
        """Bits per second, now."""
        self.restart()

    def restart(self) -> None:
        """Start anew: the robot answered until now, or the port has just been opened."""
        self._rates = cycle((self.baud, *(rate for rate in RATES if rate != self.baud)))
        self.calls = 0
        """Calls since the robot answered, or since the port was opened."""
        self._garbage = bytearray()

    def next_baud(self) -> int:
        self.calls += 1
        if self.searching:
            self.baud = next(self._rates)
        return self.baud

    def add_garbage(self, garbage: bytes) -> None:
        if len(self._garbage) < GARBAGE_LIMIT:
            self._garbage += garbage[:GARBAGE_LIMIT]

    def find_problem(self) -> str | None:
        """Return once what may be wrong, after some calls without an answer."""
        if self.calls != CALLS_BEFORE_NOTICE:
            return None
        at = TRIED if self.searching else str(self.baud)
        if len(self._garbage) >= GARBAGE_LIMIT:
            shown = ' '.join(str(byte) for byte in self._garbage[:12])
            rate = '' if self.searching else f', or another baud rate (`baud: 0` tries {TRIED})'
            return (f'something sends on the port, but not like a Create at {at} baud (it sent '
                    f'{shown} ...): if it is a Create, switch it off and on; is it another '
                    f'device{rate}? The driver keeps calling')
        hint = '' if self.searching else f'; the parameter `baud: 0` tries {TRIED}'
        return (f"no answer at {at} baud: is the robot on (Power light)? is it the Create's own "
                f'serial cable, plugged in all the way{hint}? The driver keeps calling')


WINDOW = 3.0
"""Seconds over which frames are counted."""
MIN_FRAMES, GOOD_FRAMES = 0.8, 0.9
"""Fractions of all frames: with fewer something is wrong, with more the line is well again."""


class FrameRate:
    """
    Counts frames over some seconds; `problem` says what is wrong, None while nothing is.

    Frames may be damaged on the line, cut where they do not fit into a slot (manual: Stream), or
    lost by an adapter or a network that carries less than its baud rate says.
    """

    def __init__(self, counts: LinkCounts) -> None:
        self._counts = counts
        self.problem: str | None = None
        self._begun: float | None = None
        """When the count began; None: not yet."""
        self._frames = 0
        """Frames that had come then."""

    def restart(self) -> None:
        """Start counting again: the robot was away, or does not stream."""
        self._begun = None

    def check(self, baud: int, now: float) -> bool:
        """Check what has arrived up to now; True when a problem has begun or ended."""
        begun, before = self._begun, self.problem
        if begun is not None and now < begun + WINDOW:
            return False
        frames = self._counts.frames - self._frames
        self._begun, self._frames = now, self._counts.frames
        if begun is None:
            return False
        wanted = (now - begun) / SLOT
        if frames >= GOOD_FRAMES * wanted:
            self.problem = None
        elif frames < MIN_FRAMES * wanted:
            faster = '' if baud >= START_BAUDS[0] else f'use {START_BAUDS[0]} baud, and '
            self.problem = (
                f'only {frames / (now - begun):.0f} of {1 / SLOT:.0f} frames a second arrive '
                f'whole at {baud} baud: {faster}look at plug, cable, adapter and network')
        return bool(before) != bool(self.problem)


SILENCE = 0.5
"""Seconds without a frame after which the robot is called again."""
MAX_ABSENCE = 2.0
"""Seconds without a frame after which a robot was away: only then is it called by Start, which
changes its mode, and commands must pause before it follows them again."""
STANDSTILL = 1.0
"""Seconds between two calls of the driver after which its process must have been stopped."""
WAKE_UP_FIRST, WAKE_UP_EVERY = 3, 10
"""Calls of a robot that has fallen silent among which these end a command that was cut short: the
others leave room in the queue of a robot that only waits."""
STALE_BYTES_FOR = 0.05
"""Seconds after a standstill in which the system still delivers old bytes."""


class Connection:
    """The line to the robot: whether it answers, at which rate, and how well."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self._search = BaudSearch(core.settings.baud)
        self._frame_rate = FrameRate(core.counts)
        self._garbage_before = 0
        """Bytes of garbage that had come when the last frame did."""
        self.plan = StreamPlan(self._search.baud)
        self._probe = Probe(core.outbox, self.plan)
        self._ask_again_at = 0.0
        """From when on a frame of the shortest list means that another list was not asked for."""
        self.reader = oi.StreamReader(self.plan.lists)
        self.frame_at = 0.0
        """When the last frame came, in the clock of `now`."""
        self.present_at = inf
        """When a frame came last; before the first one, when the robot was called first."""
        self._call_interval = CALL_INTERVAL
        self._ran_at = inf
        """When the driver was called last; in no past before the port is open."""
        self._stale_until = -inf
        self._unanswered: str | None = None
        """What the user was told of a robot that does not answer; None before."""
        budget = self.plan.budget
        if not budget.fits:
            core.notice(Severity.ERROR, (
                f'{budget.baud} baud is too slow: a frame of {budget.size} bytes does not fit '
                f'into {SLOT / MILLI:.0f} ms; use {START_BAUDS[1]} or more'))

    @property
    def baud(self) -> int:
        """Bits per second of the next bytes; the port has to follow."""
        return self._search.baud

    @property
    def problem(self) -> str | None:
        """What the user was told of the line; None while nothing is wrong with it."""
        if self._core.state.answered:
            return self._frame_rate.problem
        return self._unanswered

    def opened(self, now: float) -> None:
        """Start to call: the port has been opened."""
        self.present_at = min(self.present_at, now)
        self._search.restart()
        self._unanswered = None
        self._ran_at = now
        self._call(now, StateEvent.OPENED)

    def was_away(self, now: float) -> bool:
        """Tell whether a robot that is heard now was not for so long that anything may be true."""
        return now - self.present_at > MAX_ABSENCE

    def forget(self) -> None:
        """Forget how well the line works: no robot answers."""
        self.plan.asked = None
        self._core.watch.restart()
        self._frame_rate.restart()

    def feed(self, data: bytes, now: float) -> bool:
        """Take bytes in; False where they are too old to be used."""
        if now < self._stale_until:
            return False
        self.reader.feed(data)
        return True

    def add_frame(self, packets: oi.PacketList, now: float) -> None:
        """Note a verified frame; report a line that carries too little, or well again."""
        self.frame_at = now
        self._garbage_before = self._core.counts.garbage_bytes
        self._core.watch.seen(packets.ids)
        if not self._core.state.takes_commands:
            self._frame_rate.restart()
        elif self._frame_rate.check(self.baud, now):
            problem = self._frame_rate.problem
            self._core.notice(Severity.WARNING if problem else Severity.INFO,
                              problem or 'frames arrive in time again')

    def add_garbage(self, garbage: bytes) -> None:
        """Note bytes that are no frame."""
        self._core.counts.garbage_bytes += len(garbage)
        self._search.add_garbage(garbage)

    def ask(self, now: float, *, motion_due: bool) -> None:
        """Ask for another list of packets, when it is time for one."""
        core = self._core
        if core.state.takes_commands and not core.watch.suspects and not core.outbox.busy:
            stream = self.plan.next_stream(now, motion_due=motion_due)
            if stream is not None:
                core.outbox.send(stream)
                core.watch.asked(tuple(stream.packets), now)

    def check_silence(self, now: float) -> None:
        """Call the robot when no frame has come for too long."""
        answered = self._core.state.answered
        if now - self.frame_at <= (SILENCE if answered else self._call_interval):
            return
        if answered:
            self._core.counts.silences += 1
            self._search.restart()
            garbage = self._core.counts.garbage_bytes - self._garbage_before
            why = 'the robot is off, asleep or unplugged'
            if now < self._ask_again_at:
                why = IGNORES  # it sends the shortest list, but none that it was asked for since
            elif garbage > self.plan.full.frame_size:
                why = (f'{garbage} bytes came, but no frame among them: is the line disturbed, or '
                       'the robot at another baud rate')
            self._unanswered = f'no frame for {SILENCE} s: {why}; calling it until it answers'
            self._core.notice(Severity.ERROR, self._unanswered)
        rest = self.reader.flush()
        if rest is not None:
            self._search.add_garbage(rest.data)
        problem = self._search.find_problem()
        if problem is not None:
            self._unanswered = problem
            self._core.notice(Severity.ERROR, problem)
        self._call(now, StateEvent.NO_ANSWER)

    def check_standstill(self, now: float) -> None:
        """Call the robot again after this process stood still: the dead-man may have acted."""
        seconds, self._ran_at = now - self._ran_at, now
        if seconds <= STANDSTILL or not self._core.state.answered:
            return
        self._core.notice(
            Severity.WARNING, f'the driver stood still for {seconds:.1f} s (Ctrl-Z, a debugger, a '
            'computer that slept or was too busy); calling the robot again')
        self._core.outbox.clear(HALT)
        self.reader.flush()
        self._search.restart()
        self._unanswered = None
        self._core.handle(StateEvent.NO_ANSWER)
        # Old bytes are dropped first: an answer among them would be lost, with its distance.
        self._stale_until = now + STALE_BYTES_FOR
        self.frame_at = self._stale_until - self._call_interval

    def watch_commands(self, missed_since: float | None, now: float) -> None:
        """React to a robot that may ignore commands."""
        core, watch = self._core, self._core.watch
        if not core.state.takes_commands:
            watch.restart()
            return
        before = watch.level
        watch.check(missed_since, now)
        if watch.level > before:
            if watch.level is Escalation.HOLD_BACK:
                self._probe.begin(now)
            elif watch.level is Escalation.WAKE:
                core.outbox.send_raw(WAKE_UP)
            else:
                core.notice(Severity.ERROR, IGNORES)
        if watch.suspects:
            self._probe.poll(now)

    def _call(self, now: float, event: StateEvent) -> None:
        """Stop the robot and start its stream, whatever it was doing before."""
        self._core.outbox.clear()
        self._core.handle(event)
        assert self._core.state.activity is Activity.CALLING
        self.frame_at = now
        baud = self._search.next_baud()
        ask = oi.Stream(packets=self.plan.call.ids)
        if baud != self.plan.baud:
            self.plan.tune(baud)
            self.reader.expect(self.plan.lists)
        start = [] if self._core.counts.frames and not self.was_away(now) else [oi.Start()]
        calls, stop = self._search.calls, b''
        if (event is StateEvent.OPENED or self._search.searching
                or calls % WAKE_UP_EVERY == WAKE_UP_FIRST):
            # What has not left would delay a stop, or go out at the next rate.
            seconds = len(WAKE_UP) * oi.BITS_PER_BYTE / baud
            stop = WAKE_UP if seconds < CALL_INTERVAL else 2 * HALT.encode()
        elif calls == 1:
            stop = HALT.encode()  # next to nothing for a robot that may only wait
        size = len(stop) + sum(len(each.encode()) for each in (*start, ask))
        answer = self.plan.full.frame_size
        self._call_interval = max(
            CALL_INTERVAL, ANSWER_TIME + (size + answer) * oi.BITS_PER_BYTE / baud)
        self._core.outbox.send_raw(stop)
        for each in (*start, ask):
            self._core.outbox.send(each)

    def call_answered(self, now: float) -> bool:
        """
        Ask a robot that has answered a call, or `Probe`, for all packets; stop it at first.

        True when it did not seem to take commands until now.
        """
        core, again = self._core, self._core.watch.suspects
        if not core.state.answered:
            stream = self.plan.next_stream(now, motion_due=True)
            if stream is not None:
                self.frame_at = now
                core.outbox.send(HALT)
                core.outbox.send(stream)
        elif now >= self._ask_again_at:
            self._ask_again_at = now + POLL_INTERVAL
            if not core.state.takes_commands:  # a script's round may last
                self.frame_at = now
            core.watch.restart()
            self.plan.asked = None
        return again and not core.watch.suspects
