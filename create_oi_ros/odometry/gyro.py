# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A gyro on the analog input: what it feels in a window, and whether it is believed.

The filters know its zero and its scale as they know the wheels (`Filters.take_turn`); this file
adds its voltage up, frame by frame, and compares its turns with those of the wheels. Where both
agree, each corrects the other; so the zero is learned whenever the robot stands. Where they
disagree by more than both can explain, wheels slip or somebody turns the robot: the gyro is
believed, and nothing is learned. It is believed once it has followed the wheels in turns.
"""

from dataclasses import dataclass
from math import isnan, nan, radians
from typing import NamedTuple

from .estimate import GyroSettings, Known, KnownGyro

LOWEST, HIGHEST, STEP = 0.0, 5.0, 5.0 / 1023
"""Volts of the analog input, and its resolution (manual: packet 33)."""
MIDDLE, ANY_ZERO, ANY_SCALE = 2.5, 1.5, 0.03
"""V at rest; deviations of a gyro of which only the data sheet is known: V, part of the scale."""
STALE_ZERO, STALE_SCALE = 0.005, 5e-4
"""By how much a gyro that was checked may have changed until the next start."""
GATE = 12.0
"""Squared deviations beyond which wheels and gyro disagree: one in 2,000 by chance."""
LEAST_TURN, FOLLOWS = radians(10), 0.12
"""A turn that tells whether a gyro follows, and the part of it by which it may be off: a carpet
slips by a tenth."""
PROOFS, DISPROOFS = 2, 4
"""Turns in which a new gyro must follow, or does not; a known one is refuted by the first."""
SURE_ZERO = radians(0.3)
"""rad/s; with a zero less sure than that it is not used."""
SLIP, SLIP_FADES = 0.003, 0.8
"""Part of a turn that wheels slip on any floor, and of an observed slip that is expected after a
turn without one (tried)."""
JUMP, MOST_JUMPS = 25 * STEP, 5
"""V by which the voltage may leave its course, as a floating input does; how often in a row."""
ASTRAY, ANY_TURN = 0.9, 10.0
"""Part of a turn of the wheels by which a gyro that follows seldom disagrees; rad², the variance
of a turn of which wheels tell nothing."""
MOVED_ZERO = 10
"""Readings in a row in which a standing robot turns, after which the zero is learned anew."""
LONGEST_GAP = 0.1
"""Seconds between two frames, from which on nobody knows how the robot turned."""
QUIET = radians(0.5)
"""A turn of a standing robot that is taken for noise until the next reading."""
NOISE = STEP ** 2 / 4
"""Least variance of a voltage, V²: half a unit."""


class GyroState(NamedTuple):
    """What is thought of the gyro and, by it, of the wheels."""

    believed: bool
    problem: str | None
    """Why it is not believed; None where nothing is wrong."""
    slips: int
    """Readings, since the start, at which wheels and gyro disagreed."""
    slips_now: bool
    """Whether they did at the last reading."""


class Verdict(NamedTuple):
    """What a comparison with the wheels says."""

    corrects: bool
    """Whether the gyro corrects the pose."""
    teaches: bool
    """Whether zero and scale, and where it corrects the wheels, are learned."""
    slip: float
    """Variance by which the robot may have turned otherwise than its wheels, rad²."""


@dataclass
class Felt:
    """What was felt since the last reading."""

    seconds: float = 0.0
    volts: float = 0.0
    """Above `MIDDLE`, times seconds."""
    variance: float = 0.0
    """Of that, V² s²."""
    published: float = 0.0
    """rad that the pose has turned by it."""
    frames: int = 0
    unmeasured: int = 0
    """Frames in which the gyro did not tell the turn."""
    jumps: int = 0
    bends: float = 0.0
    """Sum of the squared second differences of the voltage, V²."""
    moved: bool = False
    """Whether wheels turned or should have."""
    loud: bool = False
    """Whether a standing robot turned by more than noise."""
    touched: bool = False
    """Whether a wheel hung down or the bumper was pressed: somebody may turn the robot."""


class Gyro:
    """One gyro: its window, its belief; zero and scale are those of the filters."""

    def __init__(self, settings: GyroSettings, known: KnownGyro | None) -> None:
        """Begin with a gyro of which only the data sheet is known, or that was checked."""
        self._settings, self._proven = settings, False
        self._was_known = known is not None
        """Whether it is still the file's, and not refuted."""
        if known is None:
            self._begin(settings.scale, Known(0.0, ANY_ZERO), ANY_SCALE)
        else:
            self._begin(radians(known.scale.value),
                        Known(known.zero.value - MIDDLE, known.zero.deviation + STALE_ZERO),
                        known.scale.deviation / abs(known.scale.value) + STALE_SCALE)
        self._agreed = PROOFS * self._was_known
        self.state = GyroState(False, 'its zero is not known yet: let the robot stand', 0, False)
        self.felt = Felt()
        self.rate = 0.0
        """rad/s."""
        self._slip, self._noise = 0.0, STEP ** 2
        self._slips = self._flat = False
        self._last, self._before = nan, nan
        """Volts of the last two frames."""

    def _begin(self, scale: float, zero: Known, deviation: float) -> None:
        """Begin with a scale, of which a part is not sure, and a zero."""
        self.scale, self.zero, self.scale_error = scale, zero, Known(0.0, deviation)
        """rad/s for each volt; volts above `MIDDLE`; part of the scale by which it is wrong."""
        self._agreed = self._disagreed = self._loud = 0
        self.anew = True
        """Whether the filters must begin anew with zero and scale."""

    @property
    def known(self) -> KnownGyro | None:
        """What was learned; None before it was seen to follow."""
        if not self._proven:
            return None
        scale = self.scale * (1 + self.scale_error.value) / radians(1)
        return KnownGyro(Known(self.zero.value + MIDDLE, self.zero.deviation),
                         Known(scale, abs(scale) * self.scale_error.deviation))

    @property
    def variance(self) -> float:
        """Of the rate, rad²/s²."""
        return (self.scale ** 2 * (self._noise + self.zero.deviation ** 2)
                + (self.rate * self.scale_error.deviation) ** 2)

    def turn(self, dt: float, volts: float, rolled: float, *, moved: bool,
             touched: bool) -> tuple[float, bool]:
        """
        Take a frame in; return by how much it turns the pose, rad, and whether the gyro said so.

        The wheels turned it by `rolled`; `moved`: or should have.
        """
        w = self.felt
        w.frames += 1
        w.moved |= moved  # from then on all that it feels is a turn
        w.touched |= touched
        turn = self._turn(dt, volts)
        w.seconds += dt
        if turn is None:
            w.unmeasured += 1
            w.volts += rolled / self.scale + self.zero.value * dt
            w.variance += (0.05 * rolled / self.scale) ** 2
            return rolled, False
        if not self.state.believed:
            return rolled, True
        if not (w.moved or w.touched or w.loud):  # noise does not turn a robot that stands
            whole = self._by_now()
            turn = 0.0 if abs(whole - w.published) < QUIET else whole - w.published
            w.loud |= turn != 0
        w.published += turn
        return turn, True

    def _by_now(self) -> float:
        """Return the turn since the last reading, rad."""
        w = self.felt
        return self.scale * (1 + self.scale_error.value) * (w.volts - self.zero.value * w.seconds)

    def _turn(self, dt: float, volts: float) -> float | None:
        """Return the turn in a frame, rad; None: the gyro does not tell."""
        if isnan(volts):
            return None
        if isnan(self._last):
            self._last = self._before = volts
        w, mean = self.felt, (self._last + volts) / 2 - MIDDLE
        bend = volts - 2 * self._last + self._before
        self._before, self._last = self._last, volts
        w.bends += bend * bend
        jumps = abs(bend) > JUMP
        w.jumps = w.jumps + 1 if jumps else max(0, w.jumps - 1)
        scale = self.scale * (1 + self.scale_error.value)
        self.rate = scale * (volts - MIDDLE - self.zero.value)
        at_end = not LOWEST < volts < HIGHEST - STEP / 2 or (
            self.state.believed and abs(self.rate) > 0.95 * self._settings.range)
        if at_end or w.jumps > MOST_JUMPS or dt > LONGEST_GAP:
            return None
        w.volts += mean * dt
        w.variance += dt * dt * (self._noise + bend * bend / 12 * jumps)
        return scale * (mean - self.zero.value) * dt

    # Readings.

    def judge(self, wheels: float, gyro: float, variance: float) -> Verdict:
        """
        Compare the turns of wheels and gyro since the last reading, rad.

        `variance` is that of their difference, as far as the filters know it.
        """
        w, off, most = self.felt, gyro - wheels, max(abs(wheels), abs(gyro))
        variance += (SLIP * most) ** 2
        self._slips = off * off > GATE * variance and not (w.touched or w.loud)
        stands = not (w.moved or w.touched)
        self._loud = self._loud + 1 if stands and (w.loud or self._slips) else 0
        if self._loud >= MOVED_ZERO:
            self._begin(self.scale, Known(self.zero.value, ANY_ZERO), self.scale_error.deviation)
            self._agreed = PROOFS
        if w.unmeasured > w.frames / 2:
            return Verdict(False, False, 0.0)
        if w.touched or w.loud:
            return Verdict(self.state.believed, False, ANY_TURN)
        if self.tells_scale(most):
            self._count(wheels, gyro, variance)
        if self._slips:
            self._slip = max(self._slip, min(1.0, abs(off) / max(most, LEAST_TURN)))
            return Verdict(self.state.believed and self._agreed >= PROOFS, False, off * off)
        if most > LEAST_TURN:
            self._slip *= SLIP_FADES
        if not w.moved:
            self._noise += 0.1 * (max(w.bends / 6 / w.frames, NOISE) - self._noise)
        return Verdict(self.state.believed, True, (max(self._slip, SLIP) * most) ** 2)

    def tells_scale(self, turn: float) -> bool:
        """Return whether a turn, rad, tells the scale: it is long, and the zero is known."""
        return abs(turn) > LEAST_TURN and abs(self.scale) * self.zero.deviation < SURE_ZERO

    def _count(self, wheels: float, gyro: float, variance: float) -> None:
        """Count turns in which the gyro follows the wheels, and in which not; find its sign."""
        off, most = abs(gyro - wheels), max(abs(wheels), abs(gyro))
        near = off < FOLLOWS * most + 3 * variance ** 0.5
        if near and not (self._slips and self._agreed < PROOFS):
            self._agreed, self._disagreed = min(self._agreed + 1, PROOFS), 0
            self._proven |= self._agreed >= PROOFS
            self._was_known = False
        elif self._was_known:  # another part than the file's
            self._was_known = False
            self._begin(self._settings.scale, Known(self.zero.value, ANY_ZERO), ANY_SCALE)
        elif self._agreed < PROOFS or off > ASTRAY * abs(wheels):
            self._disagreed += 1
            if self._disagreed >= DISPROOFS:
                self._agreed = 0
                if wheels * gyro < -wheels * wheels / 2:  # it is mounted upside down
                    self._begin(-self.scale, Known(self.zero.value, ANY_ZERO), ANY_SCALE)

    def learned(self, zero: Known, scale_error: Known, wheels: float) -> None:
        """Take over what the filters believe at a reading; decide whether it is believed."""
        if not self.anew:
            self.zero, self.scale_error = zero, scale_error
        w, self.felt = self.felt, Felt()
        problem = self._problem(w, wheels)
        slips = self._slips and problem is None
        self.state = GyroState(problem is None, problem, self.state.slips + slips, slips)

    def _problem(self, w: Felt, wheels: float) -> str | None:
        """Say why the gyro is not believed; None: it is."""
        if w.jumps > MOST_JUMPS:
            return 'the voltage jumps: is a gyro connected to the analog input?'
        if w.unmeasured > w.frames / 2:
            return (f'{self._last:.2f} V are beyond its range, or frames come without packet 33')
        self._flat = not w.bends and (self._flat or abs(wheels) > LEAST_TURN)
        if self._flat:
            self._agreed = 0
            return f'the voltage stays at {self._last:.2f} V though the robot turns: is it there?'
        if self._disagreed >= DISPROOFS:
            return 'it does not follow the turns of the wheels: are gyro_scale and wiring right?'
        if abs(self.scale) * self.zero.deviation > SURE_ZERO:
            return 'its zero is not known yet: let the robot stand'
        if self._agreed < PROOFS:
            return 'it has not been seen to follow the wheels yet: turn the robot'
        return None
