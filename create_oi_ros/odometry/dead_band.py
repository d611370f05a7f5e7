"""
Slow requests that may not move a wheel at all: what is known of the edge.

A Create's wheels do not turn when they are asked for less than some speed. Between the fastest
request that was seen not to move a wheel and the slowest that was seen to, the state `MOVES` of a
wheel (0 to 1) is open; readings tell, and the edge is known better from then on.
"""

from .request_history import Array

SLOWEST, FASTEST = 0.0, 0.0255
"""m/s between which the edge is looked for at the start."""
OPEN = 0.5
"""Mean and standard deviation of what an undecided wheel moves by."""
CLEAR = 0.2
"""Standard deviations to both sides are this far from the other answer when it is decided."""


class DeadBand:
    """Where the edge lies, and which wheels are undecided."""

    def __init__(self) -> None:
        self.stands, self.moves = SLOWEST, FASTEST
        """Fastest request known to stand, slowest known to move, m/s."""
        self.asked = [0.0, 0.0]
        self.open = [False, False]

    def doubt(self) -> None:
        """Note that a reading was not what was expected."""
        if any(0 < speed < FASTEST for speed in self.asked):
            self.forget()

    def forget(self) -> None:
        """Doubt again where the edge lies."""
        self.stands, self.moves = SLOWEST, FASTEST

    def ask(self, right: float, left: float) -> list[float | None]:
        """Take a request for both wheels; return what each moves by, None where nobody knows."""
        self.asked = [abs(right), abs(left)]
        answers: list[float | None] = []
        for speed in self.asked:
            if not speed or speed >= self.moves:
                answers.append(1.0)
            else:
                answers.append(0.0 if speed <= self.stands else None)
        self.open = [answer is None for answer in answers]
        return answers

    def learn(self, means: Array, spreads: Array) -> list[float | None]:
        """Return what each undecided wheel moves by, where its estimate is clear."""
        answers: list[float | None] = [None, None]
        for wheel, speed in enumerate(self.asked):
            if not self.open[wheel]:
                continue
            mean, spread = float(means[wheel]), float(spreads[wheel])
            if spread > 0.15:
                continue
            if mean < 0.35 and mean + 2 * spread < 1 - CLEAR:
                answers[wheel], self.stands = 0.0, max(self.stands, speed)
            elif mean > 0.65 and mean - 2 * spread > CLEAR:
                answers[wheel], self.moves = 1.0, min(self.moves, speed)
            self.open[wheel] = answers[wheel] is None
        if self.stands >= self.moves:
            self.forget()
        return answers
