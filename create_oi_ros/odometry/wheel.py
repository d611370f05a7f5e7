"""One wheel as it is believed to turn, and what its single-channel encoder makes of that."""

from math import copysign


class Wheel:
    """Runs to the requested speed at a constant acceleration; speeds in m/s, forwards positive."""

    __slots__ = ('speed', 'request', 'gain', 'goal', 'counts', 'ramped', 'cruised', 'pull', '_up')

    def __init__(self) -> None:
        self.speed = 0.0
        self.request = 0.0
        self.gain = 1.0
        """Speed that the wheel settles at over the speed requested."""
        self.goal = 0.0
        self.counts = 1.0
        """What the encoder counts over what the wheel travels: 1, or -1 when it has the sign of
        a command that the wheel does not follow yet."""
        self.ramped = self.cruised = 0.0
        """Seconds of the present segment spent changing speed, and at the goal."""
        self.pull = 0.0
        """Sign of the acceleration of the last ramp in the segment."""
        self._up = True

    def ask(self, request: float) -> None:
        """Set the requested speed."""
        self.request = request
        self.goal = request * self.gain
        if request or not self.speed:
            self._up = request >= 0
        self.settle_sign()

    def settle_sign(self) -> None:
        """Work out how the encoder counts from now on: by the command's sign, until at rest."""
        ahead = self.speed or self.goal
        self.counts = 1.0 if (ahead >= 0) == self._up or not ahead else -1.0

    def learn(self, gain: float) -> None:
        """Take a better gain; a wheel at its goal stays there."""
        there = self.speed == self.goal
        self.gain = gain
        self.goal = self.request * gain
        if there:
            self.speed = self.goal

    def acceleration(self, limit: float) -> float:
        """Return the present acceleration, m/s²."""
        rest = self.goal - self.speed
        return copysign(limit, rest) if rest else 0.0

    def time_to_turn(self, limit: float) -> float:
        """Return the seconds until the wheel passes through rest to reverse; 0 if it does not."""
        return abs(self.speed) / limit if self.speed * self.goal < 0 else 0.0

    def roll(self, seconds: float, limit: float) -> float:
        """Let time pass; return the metres travelled."""
        speed = self.speed
        rest = self.goal - speed
        if not rest:
            self.cruised += seconds
            return speed * seconds
        self.pull = 1.0 if rest > 0 else -1.0
        ramp = abs(rest) / limit
        if ramp <= seconds:
            self.speed = self.goal
            self.ramped += ramp
            self.cruised += seconds - ramp
            return self.goal * seconds - rest * ramp / 2
        change = self.pull * limit * seconds
        self.speed = speed + change
        self.ramped += seconds
        return (speed + change / 2) * seconds

    def open_segment(self) -> None:
        """Begin to count ramp and cruise afresh."""
        self.ramped = self.cruised = 0.0
