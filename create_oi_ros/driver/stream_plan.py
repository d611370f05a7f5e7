# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Which packets the driver asks for, and when it changes the list.

The robot sends one list of packets in every slot, and the list must fit into it. What must be
known at once (mode, bumps, cliffs, requested speeds) is in every list. Distance and angle are in
it only when the odometry asks, because reading them costs precision. The rest comes as often as
there is room. A frame of the list that is asked for may arrive late, so frames of earlier lists
are accepted too.
"""

from collections.abc import Iterator
from itertools import cycle

from .. import oi
from ..robot import SLOT

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
DRIVE_REQUEST = ('requested_velocity', 'requested_radius')
"""What the last Drive asked for; only scripts use Drive."""
ALL = ESSENTIAL + FREQUENT + MOTION + SLOW
"""Every packet that the driver keeps; unused bytes and the requests of Drive are left out."""


def _lists(baud: int) -> tuple[oi.PacketList, list[oi.PacketList], oi.PacketList]:
    """Return the list for most frames, the lists with the rest, and the list with motion."""
    everything = oi.PacketList.named(*ALL)
    if everything.budget(baud).fits:
        return oi.PacketList.named(*ESSENTIAL, *FREQUENT), [], everything
    parts, part = [], list(ESSENTIAL)
    for name in FREQUENT + SLOW:
        if not oi.PacketList.named(*part, name).budget(baud).fits:
            parts.append(oi.PacketList.named(*part))
            part = list(ESSENTIAL)
        part.append(name)
    parts.append(oi.PacketList.named(*part))
    return parts[0], parts, oi.PacketList.named(*ESSENTIAL, *MOTION)


class StreamPlan:
    """Decides which Stream command to send next."""

    def __init__(self, baud: int) -> None:
        """Plan for a baud rate."""
        self.asked: oi.PacketList | None = None
        """The list that was asked for last; None where the robot must be asked anew."""
        self._asked_at = 0.0
        self.tune(baud)

    def tune(self, baud: int) -> None:
        """Plan for another baud rate, from the start."""
        self.restart()
        self.short, self._parts, self.full = _lists(baud)
        self.knock = oi.PacketList.named('oi_mode')
        """Asked for to see whether a robot listens: no part of this Stream can do harm, while
        packet 7, read as an opcode, restarts the robot."""
        self.marker = oi.PacketList.named(*ESSENTIAL)
        """Asked for only to see whether the robot takes commands."""
        self.script = oi.PacketList.named(*ESSENTIAL, *DRIVE_REQUEST)
        """While a script plays. A waiting robot cannot be asked for another list, and to read
        distance and angle in every frame would lose most of them."""
        longer = oi.PacketList.named(*ESSENTIAL, *FREQUENT, *DRIVE_REQUEST)
        if longer.budget(baud).fits:
            self.script = longer
        self.baud = baud
        self.budget = self.full.budget(baud)
        self._rotation: Iterator[oi.PacketList] = cycle(self._parts or [self.short])

    @property
    def lists(self) -> tuple[oi.PacketList, ...]:
        """All lists whose frames may arrive."""
        return (self.short, self.full, *self._parts, self.marker, self.script, self.knock)

    def restart(self) -> None:
        """Forget what was asked for: the robot may have been switched off."""
        self.asked = None

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
        if self._parts or self.asked is self.full and not motion_due:
            return self._ask(next(self._rotation), now)
        return None

    def _ask(self, packets: oi.PacketList, now: float) -> oi.Stream:
        self.asked, self._asked_at = packets, now
        return oi.Stream(packets=packets.ids)
