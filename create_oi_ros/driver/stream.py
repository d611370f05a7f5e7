# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The stream: which packets the driver asks for.

The robot sends one list of packets in every slot, and the list must fit into it. What must be
known at once (mode, bumps, cliffs, requested speeds) is in every list. Distance and angle are in
it only when the odometry asks, because reading them costs precision. The rest comes as often as
there is room. A frame of the list that is asked for may arrive late, so frames of earlier lists
are accepted too.
"""

from itertools import cycle

from .. import oi
from ..robot import SLOT
from .listening import QUESTIONS

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


HARMLESS = ESSENTIAL[1:]
"""Without the first, whose number restarts a robot that has lost the beginning of a Stream."""
ALMOST = 0.9
"""Part of a slot after which the next frame counts as one slot later: hosts see frames come early
by up to 0.2 ms (evidence)."""


class StreamPlan:
    """Decides which list to ask for next."""

    def __init__(self, baud: int) -> None:
        self.questions = tuple(
            oi.PacketList(HARMLESS[first:] + HARMLESS[:first]) for first in range(3))
        """Lists that show the end of a script, and at once what has become of the robot."""
        self.tune(baud)

    def tune(self, baud: int) -> None:
        """Plan for another baud rate, from the start."""
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
        return (*self._parts, self.full, self.script, *self.questions, *QUESTIONS)

    def next_list(self, now: float, *, motion_due: bool) -> oi.PacketList | None:
        """
        Return the list to ask for now, when it is time for another one.

        The list with motion is replaced after one slot, without waiting for its frame, so that
        normally one frame carries it, however slow the line is.
        """
        if self.asked is not None and now - self._asked_at < ALMOST * SLOT:
            return None
        if self.asked is None or motion_due and self.asked is not self.full:
            self.asked = self.full
        elif len(self._parts) > 1 or self.asked is self.full and not motion_due:
            self.asked = next(self._rotation)
        else:
            return None
        self._asked_at = now
        return self.asked
