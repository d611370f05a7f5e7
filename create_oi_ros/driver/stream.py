# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The stream: which packets the driver asks for, and whether a whole frame arrives in every slot.

The robot sends one list of packets in every slot, and the list must fit into it. What must be
known at once (mode, bumps, cliffs, requested speeds) is in every list. Distance and angle are in
it only when the odometry asks, because reading them costs precision. The rest comes as often as
there is room. A frame of the list that is asked for may arrive late, so frames of earlier lists
are accepted too.

A frame that does not fit into its slot waits in the robot until its buffer is full, and is cut
then (manual: Stream). An adapter or a network may also carry less than its baud rate says. So
frames and bytes are counted over a few seconds.
"""

from collections.abc import Iterator
from itertools import cycle
from math import inf

from .. import oi
from ..oi.codes import START_BAUDS
from ..robot import MILLI, SLOT

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
        self.call = oi.PacketList.named('oi_mode')
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
        return (self.short, self.full, *self._parts, self.marker, self.script, self.call)

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


SLOT_TEXT = f'{SLOT / MILLI:.0f} ms'
WINDOW = 3.0
"""Seconds over which frames are counted."""
TOO_FEW, ENOUGH = 0.8, 0.9
"""Fractions of all frames: with fewer something is wrong, with more the line is well again."""
CARRIED = 0.95
"""Fraction of the wanted bytes: with more of them, missing frames are damaged, not cut."""


def too_slow(longest: oi.Budget, baud: int) -> str | None:
    """Say that a rate is too slow for the stream; None if it is not."""
    if longest.fits:
        return None
    return (f'{baud} baud is too slow: a frame of {longest.size} bytes does not fit into '
            f'{SLOT_TEXT}; use 19200 or more')


class FrameBudget:
    """Counts what arrives; `problem` says what is wrong, None while nothing is."""

    def __init__(self) -> None:
        self.problem: str | None = None
        self._begun: float | None = None
        self.check_at = -inf
        """When `check` has something to do next."""
        self._frames = self._frame_bytes = self._bytes = 0
        self.since_frame = 0
        """Bytes that have come since the last whole frame."""

    def restart(self) -> None:
        """Start counting again: the robot was away, or does not stream."""
        self._begun, self.check_at = None, -inf
        self.since_frame = 0

    def add_bytes(self, size: int) -> None:
        """Count bytes that have arrived."""
        self._bytes += size
        self.since_frame += size

    def add_frame(self, size: int) -> None:
        """Count a whole frame, and its bytes."""
        self._frames += 1
        self._frame_bytes += size
        self.since_frame = 0

    def why_silent(self, longest: oi.Budget, baud: int) -> str:
        """Say why no whole frame has come for a while."""
        if not longest.fits:
            return (f'frame budget exceeded: {baud} baud carries {longest.capacity} bytes in '
                    f'{SLOT_TEXT}, and longer frames are cut')
        if self.since_frame > longest.size:
            return (f'{self.since_frame} bytes came, but no frame among them: is the line '
                    'disturbed, or the robot at another baud rate')
        return 'the robot is off, asleep or unplugged'

    def check(self, baud: int, now: float, *, fits: bool) -> bool:
        """
        Check what has arrived up to now; True when a problem has begun or ended.

        `fits` is whether the frames that were asked for fit into their slots at this rate.
        """
        if now < self.check_at:
            return False
        before = self.problem
        if self._begun is not None:
            self._assess(baud, now - self._begun, fits=fits)
        self._begun, self.check_at = now, now + WINDOW
        self._frames = self._frame_bytes = self._bytes = 0
        return bool(before) != bool(self.problem)

    def _assess(self, baud: int, seconds: float, *, fits: bool) -> None:
        fraction = self._frames * SLOT / seconds
        if fraction >= ENOUGH:
            self.problem = None
        if fraction >= TOO_FEW or not self._frames:
            return
        size = round(self._frame_bytes / self._frames)
        wanted, came = size / SLOT, self._bytes / seconds
        arrive = f'only {self._frames / seconds:.0f} of {1 / SLOT:.0f} frames a second arrive'
        if fits and came > CARRIED * wanted:
            self.problem = (f'{arrive} whole, the others are damaged: is the plug loose, does '
                            'a motor disturb the line?')
        else:
            faster = '' if baud >= START_BAUDS[0] else f'use {START_BAUDS[0]} baud, and '
            self.problem = (
                f'frame budget exceeded: {arrive}; a frame of {size} bytes every '
                f'{SLOT_TEXT} is {wanted:.0f} bytes/s, and {came:.0f} came at {baud} '
                f'baud: {faster}look at adapter, network and cable')
