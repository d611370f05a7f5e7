# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The stream: which packets the driver asks for, and whether the robot takes commands.

The robot sends one list of packets in every slot, and the list must fit into it. What must be
known at once (mode, bumps, cliffs, requested speeds) is in every list. Distance and angle are in
it only when the odometry asks, because reading them costs precision. The rest comes as often as
there is room. A frame of the list that is asked for may arrive late, so frames of earlier lists
are accepted too.

The line to the robot has no checksum and no acknowledgement. Two things show that it took
commands: it streams another list of packets when asked to, and it reports the speeds that it was
sent. A robot that takes nothing, though its stream goes on, is in the middle of a command, or it
waits: for a script that another program has started, or for damaged bytes that read as a Wait.
What it is sent meanwhile may be lost, in part even, or be obeyed afterwards until its queue is
full. So it is sent next to nothing, and nothing whose loss in part can do harm.
"""

from enum import IntEnum
from itertools import cycle

from .. import oi
from ..robot import SLOT
from .outbox import Outbox

ESSENTIAL = (
    'bumps_and_wheel_drops', 'cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right',
    'oi_mode', 'requested_right_velocity', 'requested_left_velocity',
)
FREQUENT = (
    'wall', 'virtual_wall', 'overcurrents', 'infrared', 'buttons', 'charging_sources',
    'song_playing', 'song_number', 'wall_signal', 'cliff_left_signal', 'cliff_front_left_signal',
    'cliff_front_right_signal', 'cliff_right_signal', 'digital_inputs', 'analog_signal',
)
MOTION = ('distance', 'angle')
SLOW = (
    'charging_state', 'voltage', 'current', 'battery_temperature', 'battery_charge',
    'battery_capacity',
)
requested_speeds = oi.Readings.numbers('requested_right_velocity', 'requested_left_velocity')
"""What the last Drive Direct asked for, as the robot reports it in every frame, mm/s."""
DRIVE_REQUEST = ('requested_velocity', 'requested_radius')
"""What the last Drive asked for; only scripts use Drive."""
ALL = ESSENTIAL + FREQUENT + MOTION + SLOW
"""Every packet that the driver keeps; unused bytes and the requests of Drive are left out."""


class StreamPlan:
    """Decides which Stream command to send next."""

    def __init__(self, baud: int) -> None:
        self.call = oi.PacketList(['infrared'])
        """Asked for to see whether a robot listens: no part of this Stream can do harm, not even
        read at another rate, where the mode's restarts the robot or starts Cover."""
        self.marker = oi.PacketList(ESSENTIAL)
        """Asked for only to see whether the robot takes commands."""
        self.tune(baud)

    def tune(self, baud: int) -> None:
        """Plan for another baud rate, from the start."""
        self.baud = baud
        self.asked: oi.PacketList | None = None
        """The list that was asked for last; None where the robot must be asked anew."""
        self._asked_at = 0.0
        self.full = oi.PacketList(ALL)
        """All packets; where that does not fit, those with distance and angle."""
        self._parts = [oi.PacketList([*ESSENTIAL, *FREQUENT])]
        """Asked for in turn in most frames; several where not all fits into a slot."""
        self.script = oi.PacketList([*ESSENTIAL, *FREQUENT, *DRIVE_REQUEST])
        """While a script plays. A waiting robot cannot be asked for another list, and to read
        distance and angle in every frame would lose most of them."""
        if not self.script.budget(baud).fits:
            self.script = oi.PacketList([*ESSENTIAL, *DRIVE_REQUEST])
        if not self.full.budget(baud).fits:
            self._parts, part = [], list(ESSENTIAL)
            for name in FREQUENT + SLOW:
                if not oi.PacketList([*part, name]).budget(baud).fits:
                    self._parts.append(oi.PacketList(part))
                    part = list(ESSENTIAL)
                part.append(name)
            self._parts.append(oi.PacketList(part))
            self.full = oi.PacketList([*ESSENTIAL, *MOTION])
        self.budget = self.full.budget(baud)
        self.short = self._parts[0]
        self._rotation = cycle(self._parts)

    @property
    def lists(self) -> tuple[oi.PacketList, ...]:
        """All lists whose frames may arrive."""
        return (*self._parts, self.full, self.marker, self.script, self.call)

    def next_stream(self, now: float, *, motion_due: bool) -> oi.Stream | None:
        """
        Return the command that changes the list, when it is time for one.

        The list with motion is replaced after one slot, without waiting for its frame, so that
        normally one frame carries it, however slow the line is.
        """
        if self.asked is None:
            return self._ask(self.full, now)
        if now - self._asked_at < SLOT:
            return None
        if motion_due and self.asked is not self.full:
            return self._ask(self.full, now)
        if len(self._parts) > 1 or self.asked is self.full and not motion_due:
            return self._ask(next(self._rotation), now)
        return None

    def _ask(self, packets: oi.PacketList, now: float) -> oi.Stream:
        self.asked, self._asked_at = packets, now
        return oi.Stream(packets=packets.ids)


IGNORES = ('the robot ignores commands, even a stop: damaged bytes may have told it to wait; '
           'lift it, switch it off and on')
POLL_INTERVAL, POLL_FRACTION = 0.2, 0.2
"""Seconds between two polls of a robot that may wait; at least this part of the time for which it
was polled, so that a long wait gets few."""


class Escalation(IntEnum):
    """What the driver does as long as the robot shows no sign that it takes commands."""

    NONE = 0
    HOLD_BACK = 1
    """Send next to nothing: it may wait, or be in the middle of a command."""
    WAKE = 2
    """Send what ends a command that was cut short."""
    REPORT = 3
    """Tell the user."""


ESCALATION_TIMES = (0.3, 0.9, 1.5)
"""Seconds without a sign after which each of these begins."""


class CommandWatch:
    """Compares what the robot does with what it was asked for."""

    def __init__(self) -> None:
        self.restart()

    @property
    def suspects(self) -> bool:
        """Whether the robot may not take commands."""
        return self.level is not Escalation.NONE

    @property
    def ignores(self) -> bool:
        """Whether the robot ignores commands, and the user was told."""
        return self.level is Escalation.REPORT

    def restart(self) -> None:
        """Start again: the robot was away, takes commands, or cannot take them now."""
        self._list: tuple[int, ...] | None = None
        """The packets of the newest frame."""
        self._unseen_since: float | None = None
        self.level = Escalation.NONE

    def asked(self, packets: tuple[int, ...], now: float) -> None:
        """Note that the robot was asked for frames with these packets."""
        if self._unseen_since is None and self._list not in (None, packets):
            self._unseen_since = now

    def seen(self, packets: tuple[int, ...]) -> None:
        """Note the packets of a frame; where they change, the robot took a command."""
        if packets != self._list:
            self._list, self._unseen_since = packets, None

    def check(self, missed_since: float | None, now: float) -> None:
        """Update the level; `missed_since`: when speeds were sent that the robot has not taken."""
        times = [since for since in (missed_since, self._unseen_since) if since is not None]
        if not times:
            self.level = Escalation.NONE
            return
        waits = now - min(times)
        self.level = max(self.level, Escalation(sum(waits > limit for limit in ESCALATION_TIMES)))


class Probe:
    """
    Asks a robot that streams, ever more seldom, for frames of the shortest list.

    While it waits it loses that, or obeys it later. The first such frame shows that it listens.
    """

    def __init__(self, outbox: Outbox, plan: StreamPlan) -> None:
        self._outbox = outbox
        self._plan = plan
        self._since = self._due = 0.0
        self._asked = False

    def begin(self, due: float) -> None:
        """Ask from a moment on."""
        self._since = self._due = due
        self._asked = False

    def poll(self, now: float) -> None:
        """Ask, when it is time."""
        if now >= self._due and not self._outbox.busy:
            self._outbox.send(oi.Stream(packets=self._plan.call.ids))
            self._due = now + max(POLL_INTERVAL, POLL_FRACTION * (now - self._since))
            self._asked = True

    def answered(self) -> bool:
        """Note a frame of that list; True for the first since it was asked for."""
        first, self._asked = self._asked, False
        return first
