"""
When to ask the robot for distance and angle.

Each reading costs what is below a whole unit, so the robot is asked once a window, and while the
wheels run at their goals where that is possible. As long as its rounding is unknown, it is also
asked in some frames in a row at moments at which the roundings would answer differently.
"""

from .assumptions import DEGREE, MM
from .beliefs import Beliefs
from .errors import RAMP
from .rounding import Rounding

SLOT = 0.015
ANSWER = 6
"""Frames within which a reading that was asked for arrives, or is asked for again."""
PATIENCE = 1.5
"""Windows after which a reading no longer waits for the wheels to reach their goals."""
FREE = 0.5
"""Windows between readings while the wheels do not do what was requested."""
WAITS = 0.5, 1.0
"""Windows between readings, at least and at most, ..."""
STEADY_WAITS = 0.5, 2.0
"""... and once the rounding is known, while the requests stay the same, ..."""
UNSURE = 0.1
"""Relative error of the acceleration above which a reading waits for ramps to end, ..."""
SETTLED, UNSETTLED = 1.0, 2.5
"""... for so many seconds after a request, and so many windows at most."""
GOLDEN = 0.618
"""... and the step that fills this range evenly."""
PROBE = 8
"""Frames of a probe."""
PROBE_EVERY = 1.0
"""Seconds from one probe to the next."""
STEADY = 0.2
"""Seconds without a change of request before a probe."""


class ReadingPlan:
    """Decides after each frame whether the next one should carry a reading."""

    def __init__(self, window: float) -> None:
        self.window = window
        self.due = True
        self._age = self._steady = self._probed = 0.0
        self._probe = self._readings = 0
        self._asked = ANSWER + 1

    @property
    def pending(self) -> bool:
        """Whether a reading that was asked for may be under way."""
        return self._asked <= ANSWER

    def came(self) -> None:
        """Note that a reading has come."""
        self._age = 0.0
        self._readings += 1
        self._asked = ANSWER + 1

    def hurry(self) -> None:
        """Ask soon: what the robot does has changed for a reason of its own."""
        self._age = PATIENCE * self.window

    def step(self, dt: float, *, steady: bool, beliefs: Beliefs) -> bool:
        """
        Let a frame pass; `steady`: with the same requests as the one before.

        Return whether it was the last one in which the answer to a question could have come.
        """
        self._age += dt
        self._probed += dt
        self._steady = self._steady + dt if steady else 0.0
        self._asked += 1
        in_vain = self._asked == ANSWER
        if self._probe:
            self._probe -= 1
            self.due = True
        elif self.pending:
            self.due = False
        elif self._worth_a_probe(beliefs):
            self._probe, self._probed = PROBE, 0.0
            self.due = True
        else:
            self.due = self._age >= self._patience(beliefs)
        if self.due:
            self._asked = 0
        return in_vain

    def _patience(self, beliefs: Beliefs) -> float:
        """
        Return the seconds to wait after the last reading.

        They vary: steady motion read at even intervals would be rounded alike each time.
        """
        best = beliefs.best
        if best.free is not None:
            return FREE * self.window
        if best.errors.variance(RAMP) > UNSURE ** 2 and self._steady < SETTLED:
            # A ramp that is half over tells little of an acceleration that is hardly known.
            return UNSETTLED * self.window
        plain = len(beliefs.roundings) == 1 and self._steady > self._age
        shortest, longest = STEADY_WAITS if plain else WAITS
        varied = self.window * (shortest + (longest - shortest) * (self._readings * GOLDEN % 1))
        return varied * (1.0 if best.settled else PATIENCE)

    def _worth_a_probe(self, beliefs: Beliefs) -> bool:
        """Tell whether readings in a row would now tell the roundings that are left apart."""
        best, roundings = beliefs.best, beliefs.roundings
        if (len(roundings) == 1 or self._steady < STEADY or self._probed < PROBE_EVERY
                or not best.settled or best.free is not None):
            return False
        right, left = best.speeds
        steps = ((right + left) / 2 / MM, (right - left) / best.separation / DEGREE)
        rests = [abs(step * SLOT) % 1 for step in steps]
        # Above a half, rounding gains what truncation loses; below it both lose the same.
        return any(0.62 < rest < 0.88 or Rounding.CARRY in roundings and 0.15 < rest < 0.38
                   for rest in rests)
