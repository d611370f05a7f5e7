# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Whether a whole frame arrives in every slot.

A frame that does not fit into its slot waits in the robot until its buffer is full, and is cut
then (manual: Stream). An adapter or a network may also carry less than its baud rate says. So
frames and bytes are counted over a few seconds.
"""

from math import inf

from .. import oi
from ..oi.codes import START_BAUDS
from ..robot import MILLI, SLOT

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
