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
from .events import Severity
from .listening import ASK_INTERVAL, IGNORES, QUESTIONS
from .outbox import HALT, WAKE_UP
from .state import Activity, StateEvent
from .stream import StreamPlan

CALL_INTERVAL = 0.3
"""Seconds between two calls; more at rates where a call and its answer take longer."""
CALL_SIZE = len(oi.Start().encode()) + len(oi.Stream(packets=QUESTIONS[0].ids).encode())
"""Bytes of a call at most, but for what stops the wheels."""
ANSWER_TIME = 0.1
"""Seconds from the end of a call to its answer."""
RATES = (*START_BAUDS, FAST_BAUD)
"""Bits per second at which a robot is looked for whose rate is not known."""
TRIED = ', '.join(map(str, RATES))
GARBAGE_LIMIT = 64
"""Bytes without a frame after which something else must be on the line."""
CALLS_BEFORE_NOTICE = 3
"""Calls without an answer before the user is told; a robot that boots misses one or two."""
CALLS_OF_RESTART = 14
"""Calls after which a robot that has said that it restarts should have answered."""
BOOT_TEXTS = b'bl-start', b'RDK by iRobot'
"""What a Create says while it starts (reported)."""
RESTARTS = ('the robot restarts, by its boot text: it was switched on or reset, or its battery '
            'gave way for a moment')
WAKE_UP_FIRST, WAKE_UP_EVERY = 3, 10
"""Calls of a robot that has fallen silent among which these end a command that was cut short: the
others leave room in the queue of a robot that only waits."""

SILENCE = 0.5
"""Seconds without a frame after which the robot is called again."""
MAX_ABSENCE = 2.0
"""Seconds without a frame after which a robot was away: only then is it called by Start, which
changes its mode, and commands must pause before it follows them again."""
STANDSTILL = 1.0
"""Seconds between two calls of the driver after which its process must have been stopped."""
STALE_BYTES_FOR = 0.05
"""Seconds after a standstill in which the system still delivers old bytes."""

WINDOW = 3.0
"""Seconds over which frames are counted."""
MIN_FRAMES, GOOD_FRAMES = 0.8, 0.9
"""Fractions of all frames: with fewer something is wrong, with more the line is well again."""


class Connection:
    """The line to the robot: whether it answers, at which rate, and how well."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self._searching = core.settings.baud == 0
        self.baud = core.settings.baud or RATES[0]
        """Bits per second of the next bytes; the port has to follow."""
        self.plan = StreamPlan(self.baud)
        self.reader = oi.StreamReader(self.plan.lists)
        self._restart_calls()
        self._call_interval = CALL_INTERVAL
        self.frame_at = 0.0
        """When the last frame came, in the clock of `now`."""
        self.present_at = inf
        """When a frame came last; before the first one, when the robot was called first."""
        self._ask_again_at = 0.0
        """From when on a frame that answers no question shows a robot that missed a request."""
        self._ran_at = inf
        """When the driver was called last; before that, in no past."""
        self.stale_until = -inf
        """Until when bytes that arrive are too old to be used."""
        self._restarts = False
        """Whether boot text came since the last frame."""
        self._too_few: str | None = None
        """What the user was told of a line that carries too few frames; None while it is well."""
        self._counted_from: float | None = None
        """When the count of frames began; None: not yet."""
        self._frames_before = 0
        """Frames that had come then."""
        budget = self.plan.budget
        if not budget.fits:
            core.notice(Severity.ERROR, (
                f'{budget.baud} baud is too slow: a frame of {budget.size} bytes does not fit '
                f'into {SLOT / MILLI:.0f} ms; use {START_BAUDS[1]} or more'))

    def _restart_calls(self) -> None:
        """Begin to call: the robot answered until now, or the port has just been opened."""
        self._core.listening.begin()
        self._rates = cycle((self.baud, *(rate for rate in RATES if rate != self.baud)))
        self._calls = 0
        self._garbage = b''
        self._unanswered: str | None = None
        """What the user was told of a robot that does not answer; None before."""

    @property
    def problem(self) -> str | None:
        """What the user was told of the line; None while nothing is wrong with it."""
        return self._too_few if self._core.state.answered else self._unanswered

    def opened(self, now: float) -> None:
        """Start to call: the port has been opened."""
        self.present_at = min(self.present_at, now)
        self._restart_calls()
        self._call(now)

    def was_away(self, now: float) -> bool:
        """Tell whether a robot that is heard now was not for so long that anything may be true."""
        return now - self.present_at > MAX_ABSENCE

    # What arrives.

    def take_answer(self, packets: oi.PacketList, now: float) -> bool:
        """
        Tell whether a frame of this list answers the open question.

        A robot that answers is asked for all packets; after a call, or a script, its wheels are
        stopped first. One that goes on with the list of a question has missed that.
        """
        core, answers = self._core, self._core.listening.answered(packets)
        if answers:
            self.frame_at, self._ask_again_at = now, now + ASK_INTERVAL
            if not core.state.takes_commands:
                core.outbox.send_at_once(HALT, now)
            self.plan.asked = None
        elif packets in QUESTIONS and core.state.activity is Activity.SCRIPT:
            self.frame_at = now  # the script itself may have asked for this list
        elif packets in QUESTIONS and core.state.takes_commands and now >= self._ask_again_at:
            self._ask_again_at = now + ASK_INTERVAL
            core.listening.trust()
            core.outbox.send(oi.Stream(packets=self.plan.short.ids))
        return answers

    def add_frame(self, now: float) -> None:
        """Note a verified frame."""
        self.frame_at, self._restarts = now, False
        if self._core.state.takes_commands:
            self._count_frames(now)
        else:
            self._counted_from = None

    def add_garbage(self, garbage: bytes) -> None:
        """Note bytes that are no frame."""
        self._core.counts.garbage_bytes += len(garbage)
        if any(text in garbage for text in BOOT_TEXTS):
            self._restarts, garbage = True, b''
        self._garbage += garbage[:GARBAGE_LIMIT - len(self._garbage)]

    def _count_frames(self, now: float) -> None:
        """
        Report a line that carries too few frames, or well again.

        Frames may be damaged on the line, cut where they do not fit into a slot (manual: Stream),
        or lost by an adapter or a network that carries less than its baud rate says.
        """
        begun, before, total = self._counted_from, self._too_few, self._core.counts.frames
        if begun is not None and now < begun + WINDOW:
            return
        frames = total - self._frames_before
        self._counted_from, self._frames_before = now, total
        if begun is None:
            return
        wanted = (now - begun) / SLOT
        if frames >= GOOD_FRAMES * wanted:
            self._too_few = None
        elif frames < MIN_FRAMES * wanted:
            faster = '' if self.baud >= START_BAUDS[0] else f'use {START_BAUDS[0]} baud, and '
            self._too_few = (
                f'only {frames / (now - begun):.0f} of {1 / SLOT:.0f} frames a second arrive '
                f'whole at {self.baud} baud: {faster}look at plug, cable, adapter and network')
        if self._too_few and not before:
            self._core.notice(Severity.WARNING, self._too_few)
        elif before and not self._too_few:
            self._core.notice(Severity.INFO, 'frames arrive in time again')

    # What is sent.

    def ask(self, now: float, *, motion_due: bool) -> None:
        """Ask for another list of packets, when it is time for one."""
        core = self._core
        if not core.listening.may_send or core.outbox.busy:
            return
        # A robot that has not shown the last list may wait; one that was called gets one list.
        motion_due = motion_due and core.listening.unseen_since is None or not core.state.answered
        packets = self.plan.next_list(now, motion_due=motion_due)
        if packets is not None:
            core.outbox.send(oi.Stream(packets=packets.ids))
            core.listening.asked(packets, now)

    def check_silence(self, now: float) -> None:
        """Call the robot when no frame has come for too long."""
        answered = self._core.state.answered
        if now - self.frame_at <= (SILENCE if answered else self._call_interval):
            return
        rest = self.reader.flush()
        if rest is not None:
            self.add_garbage(rest.data)
        if answered:
            self._core.counts.silences += 1
            self._restart_calls()
            garbage = self._core.counts.garbage_bytes - self._core.garbage_before
            why = 'the robot is off, asleep or unplugged'
            if self._restarts:
                why = RESTARTS
            elif now < self._ask_again_at:
                why = IGNORES  # it answered a question, but has sent no list that it was asked for
            elif garbage > self.plan.full.frame_size:
                why = (f'{garbage} bytes came, but no frame among them: is the line disturbed, or '
                       'the robot at another baud rate')
            self._unanswered = f'no frame for {SILENCE} s: {why}; calling it until it answers'
            self._core.notice(Severity.ERROR, self._unanswered)
        elif self._calls == (
                CALLS_OF_RESTART if self._restarts and self._unanswered else CALLS_BEFORE_NOTICE):
            self._restarts = self._restarts and self._unanswered is None
            before, self._unanswered = self._unanswered, self._no_answer()
            if self._unanswered != before:
                self._core.notice(Severity.ERROR, self._unanswered)
        self._call(now)

    def _no_answer(self) -> str:
        """Say what may be wrong, after some calls without an answer."""
        if self._restarts:
            return f'{RESTARTS}; calling it until it answers'
        at = TRIED if self._searching else str(self.baud)
        if len(self._garbage) == GARBAGE_LIMIT:
            shown = ' '.join(str(byte) for byte in self._garbage[:12])
            rate = '' if self._searching else f', or another baud rate (baud 0 tries {TRIED})'
            return (f'something sends on the port, but not like a Create at {at} baud (it sent '
                    f'{shown} ...): if it is a Create, switch it off and on; is it another '
                    f'device{rate}? The driver keeps calling')
        hint = '' if self._searching else f'; baud 0 tries {TRIED}'
        return (f"no answer at {at} baud: is the robot on (Power light)? is it the Create's own "
                f'serial cable, plugged in all the way{hint}? The driver keeps calling')

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
        self._restart_calls()
        self._core.handle(StateEvent.CALLED)
        # Old bytes are dropped first: an answer among them would be lost, with its distance.
        self.stale_until = now + STALE_BYTES_FOR
        self.frame_at = self.stale_until - self._call_interval

    def _call(self, now: float) -> None:
        """Stop the robot and start its stream, whatever it was doing before."""
        core, opened = self._core, self._core.state.activity is Activity.CLOSED
        core.outbox.clear()
        core.handle(StateEvent.CALLED)
        assert core.state.activity is Activity.CALLING
        self.frame_at = now
        self._calls += 1
        if self._searching:
            self.baud = next(self._rates)
            self.plan.tune(self.baud)
            self.reader.expect(self.plan.lists)
        stop = b''
        if opened or self._searching or self._calls % WAKE_UP_EVERY == WAKE_UP_FIRST:
            # What has not left would delay a stop, or go out at the next rate.
            seconds = len(WAKE_UP) * oi.BITS_PER_BYTE / self.baud
            stop = WAKE_UP if seconds < CALL_INTERVAL else 2 * HALT.encode()
        elif self._calls == 1:
            stop = HALT.encode()  # next to nothing for a robot that may only wait
        core.outbox.send_raw(stop)
        if not core.counts.frames or self.was_away(now):
            core.outbox.send(oi.Start())
        core.listening.ask()
        size = len(stop) + CALL_SIZE + self.plan.full.frame_size
        self._call_interval = max(CALL_INTERVAL, ANSWER_TIME + size * oi.BITS_PER_BYTE / self.baud)
