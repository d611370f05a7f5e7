# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Faults that happen on purpose: `create_sim --fault SPEC`, any number of times.

    SPEC = KIND[:RATE][@START][+DURATION][~PERIOD]        seconds, on the robot's clock

    flip, drop, garbage       one bit flipped, one byte lost, 1 to 20 random bytes put in front;
                              happens to the part RATE (0 to 1) of the robot's frames and replies,
                              with `.in` (flip.in) to that part of what the host sends
    silence, deaf, cut        bytes from the robot, to the robot, both ways are lost
    unplug                    the port disappears and comes back
    brownout                  the battery fails for a moment

The last five happen RATE times a second at random, or at START; each lasts DURATION (1 s) and
repeats every PERIOD (`@10` alone is once). The first three can be limited to such times.

    --fault flip:0.05 --fault unplug@20+3 --fault cut:0.1+0.5 --fault garbage:1@30+5~60

The same seed gives the same faults.
"""

from dataclasses import dataclass
from enum import Enum
import math
from random import Random
import re

from ...robot import SLOT
from .. import TOLERANCE

MOST_GARBAGE = 20
"""Bytes at once."""


class FaultKind(Enum):
    FLIP = 'flip'
    DROP = 'drop'
    GARBAGE = 'garbage'
    FLIP_IN = 'flip.in'
    DROP_IN = 'drop.in'
    GARBAGE_IN = 'garbage.in'
    SILENCE = 'silence'
    DEAF = 'deaf'
    CUT = 'cut'
    UNPLUG = 'unplug'
    BROWNOUT = 'brownout'


DAMAGE_FROM_ROBOT = (FaultKind.FLIP, FaultKind.DROP, FaultKind.GARBAGE)
DAMAGE_TO_ROBOT = (FaultKind.FLIP_IN, FaultKind.DROP_IN, FaultKind.GARBAGE_IN)
DAMAGE = DAMAGE_FROM_ROBOT + DAMAGE_TO_ROBOT
NUMBER = r'(\d+\.?\d*|\.\d+)'
SPEC = re.compile(
    rf'([a-z.]+)(?::{NUMBER})?(?:@{NUMBER})?(?:\+{NUMBER})?(?:~{NUMBER})?')


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault: its kind, and its rate, its times or both, as in a SPEC."""

    kind: FaultKind
    rate: float | None = None
    start: float | None = None
    duration: float = math.inf
    period: float = math.inf

    @classmethod
    def parse(cls, spec: str) -> 'Fault':
        """Read a SPEC; ValueError says what is wrong and what is allowed."""
        match = SPEC.fullmatch(spec)
        kinds = {kind.value: kind for kind in FaultKind}
        if match is None or match[1] not in kinds:
            raise ValueError(
                f'fault {spec!r}; allowed: KIND[:RATE][@START][+DURATION][~PERIOD] with KIND one '
                f'of {", ".join(kinds)}')
        kind = kinds[match[1]]
        rate, start, duration, period = (
            None if text is None else float(text) for text in match.groups()[1:])
        damage = kind in DAMAGE
        if rate is None and (damage or start is None):
            missing = 'a rate (":0.1")' if damage else 'a rate (":0.1") or a start ("@10")'
            raise ValueError(f'fault {spec!r}: add {missing}')
        if damage and rate is not None and rate > 1:
            raise ValueError(f'fault {spec!r}: rate {rate:g}; allowed for {kind.value}: 0 to 1')
        return cls(kind, rate, start, duration if duration is not None else
                   math.inf if damage else 1.0, period or math.inf)

    def within(self, time: float) -> bool:
        """Return whether the fault may happen at this time, in seconds."""
        if self.start is None:
            return True
        since = time - self.start + TOLERANCE
        return since >= 0 and (since % self.period) < self.duration


class Faults:
    """All faults of one robot and its line."""

    def __init__(self, faults: list[Fault], seed: int = 0) -> None:
        self.faults = faults
        self._random = Random(seed)
        self._until: dict[Fault, float] = {}
        self._active: set[FaultKind] = set()
        self.cable_cut = False
        """Whether the control socket has cut the cable."""

    def step(self, time: float) -> set[FaultKind]:
        """Advance to `time`, a slot at a time; return the kinds that started in this slot."""
        before = self._active
        self._active = {fault.kind for fault in self.faults
                        if fault.kind not in DAMAGE and self._lasts(fault, time)}
        return self._active - before

    def active(self, kind: FaultKind) -> bool:
        """Return whether a fault of this kind lasts now; never true for flip, drop, garbage."""
        return kind in self._active

    def _lasts(self, fault: Fault, time: float) -> bool:
        if fault.rate is None:
            return fault.within(time)
        if fault.within(time) and self._random.random() < fault.rate * SLOT:
            self._until[fault] = time + fault.duration
        return time < self._until.get(fault, -math.inf)

    def from_robot(self, data: bytes, time: float) -> bytes:
        """Return what the host receives of bytes from the robot."""
        return self._passed(data, time, FaultKind.SILENCE, DAMAGE_FROM_ROBOT)

    def to_robot(self, data: bytes, time: float) -> bytes:
        """Return what the robot receives of bytes from the host."""
        return self._passed(data, time, FaultKind.DEAF, DAMAGE_TO_ROBOT)

    def _passed(self, data: bytes, time: float, loss: FaultKind,
                damage: tuple[FaultKind, ...]) -> bytes:
        """Return what is left of bytes in one direction."""
        if self.cable_cut or self._active & {loss, FaultKind.CUT, FaultKind.UNPLUG}:
            return b''
        random = self._random
        for fault in self.faults:
            if not (data and fault.kind in damage and fault.within(time)
                    and random.random() < (fault.rate or 0.0)):
                continue
            if fault.kind in (FaultKind.GARBAGE, FaultKind.GARBAGE_IN):
                data = random.randbytes(random.randint(1, MOST_GARBAGE)) + data
                continue
            place = random.randrange(len(data))
            flips = fault.kind in (FaultKind.FLIP, FaultKind.FLIP_IN)
            instead = bytes([data[place] ^ 1 << random.randrange(8)]) if flips else b''
            data = data[:place] + instead + data[place + 1:]
        return data
