"""
Several tracks at once, one for each assumption that is still plausible.

Neither the rounding nor the wheels' acceleration is documented. A reading is more likely under
one assumption than under another; the product of these likelihoods is the assumption's weight.
"""

from math import sqrt

from .errors import RAMP
from .estimate import Geometry
from .rounding import Rounding
from .track import Track

ACCELERATIONS = (0.85, 1.3, 0.55, 2.0, 0.35, 3.1)
"""First guesses, m/s², the likeliest first; each can learn what lies halfway to the next."""
IMPLAUSIBLE = 1e-7
"""Weight below which an assumption is given up."""
ALIKE = 0.15
"""Relative spread of the acceleration below which two tracks may be found to be one."""
BETRAYALS = 3
"""Surprises within the memory below after which everything is learned again."""
MEMORY = 60
"""Readings."""


class Beliefs:
    """The plausible tracks, best first."""

    def __init__(self, geometry: Geometry) -> None:
        self.tracks = [Track(rounding, acceleration, geometry)
                       for rounding in Rounding for acceleration in ACCELERATIONS]
        self.roundings = frozenset(Rounding)
        """What the robot's rounding may be."""
        self.rivals: list[Track] = []
        """The best track of each other rounding."""
        self._surprised: list[int] = []
        self._readings = 0

    @property
    def best(self) -> Track:
        """The most plausible track."""
        return self.tracks[0]

    def read(self, distance: int, angle: int, *, driven: bool) -> None:
        """Take a reading in."""
        surprises = self.best.surprises
        for track in self.tracks:
            track.weight *= track.read(distance, angle)
        if driven and self.best.surprises > surprises:
            self._surprised.append(self._readings)
        self._readings += 1
        self._judge()
        if sum(self._readings - when <= MEMORY for when in self._surprised) >= BETRAYALS:
            self._surprised.clear()
            self._learn_again()

    def _judge(self) -> None:
        """Weigh the tracks, best first; drop the implausible and the superfluous."""
        total = sum(track.weight for track in self.tracks)
        kept: list[Track] = []
        for track in sorted(self.tracks, key=lambda track: -track.weight):
            track.weight /= total
            twin = next((other for other in kept if _alike(track, other)), None)
            if twin is not None:
                twin.weight += track.weight
            elif track.weight > IMPLAUSIBLE or not kept:
                kept.append(track)
        self.tracks = kept
        self.roundings = frozenset(track.rounding for track in kept)
        self.rivals = [next(track for track in kept if track.rounding is rounding)
                       for rounding in self.roundings - {kept[0].rounding}]

    def _learn_again(self) -> None:
        best = self.best
        self.roundings = frozenset(Rounding)
        self.tracks = [best.fork(rounding, acceleration)
                       for rounding in Rounding
                       for acceleration in (best.acceleration, *ACCELERATIONS)]


def _alike(a: Track, b: Track) -> bool:
    if a.rounding is not b.rounding:
        return False
    spread = sqrt(a.errors.variance(RAMP)), sqrt(b.errors.variance(RAMP))
    return (max(spread) < ALIKE
            and abs(a.acceleration / b.acceleration - 1) < 2 * (spread[0] + spread[1]))
