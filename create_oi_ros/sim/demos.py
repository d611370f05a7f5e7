"""
The ten demos, as behaviours that one recognises: a few lines each, not iRobot's own programs.

A demo is a generator.  It looks at `Controls`, sets the wheels, and yields; a slot later it is
asked to go on.  It ends by returning, and whoever aborts it closes it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from random import Random

from create_oi_ros.oi import DemoNumber, Note
from create_oi_ros.sim.actuators import Actuators, Wheels
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.readings import Readings

Demo = Iterator[None]


class Controls:
    """What a demo may touch."""

    def __init__(self, body: Body, actuators: Actuators, random: Random,
                 sound: Callable[[Sequence[Note]], None]) -> None:
        self._body, self._actuators = body, actuators
        self.random = random
        self.sound = sound

    @property
    def sense(self) -> Readings:
        """The sensors as they are in this slot."""
        return self._body.sense()

    @property
    def angle(self) -> float:
        """Degrees turned since the start, counter-clockwise."""
        return self._body.angle_total

    @property
    def distance(self) -> float:
        """Millimetres driven since the start."""
        return self._body.distance_total

    def drive(self, right: float, left: float) -> None:
        """Set the wheels, mm/s."""
        self._actuators.turn_wheels(Wheels(right, left))


def figure_eight(controls: Controls) -> Demo:
    """Drive one circle to the left, one to the right, and so on."""
    while True:
        for right, left in ((250, 100), (100, 250)):
            start = controls.angle
            controls.drive(right, left)
            while abs(controls.angle - start) < 360:
                yield


DEMOS: dict[DemoNumber, Callable[[Controls], Demo]] = {
    DemoNumber.DRIVE_FIGURE_EIGHT: figure_eight,
}
