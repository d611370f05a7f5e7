# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The demos that drive, as recognisable behaviours of a few lines each; not iRobot's own programs.

A demo is a generator. It reads `Controls`, sets the wheels and yields until the next slot. It ends
when it returns, or is aborted when it is dropped. Speeds are in mm/s, distances in mm, angles in
degrees counter-clockwise.
"""

from collections.abc import Callable, Iterator
import math
from random import Random

from ...oi import DemoNumber, Infrared
from ...oi.codes import BEAMS, GREEN_BUOY, RED_BUOY
from ...oi.commands import WheelSpeeds
from ...robot import MM_PER_M, SLOT
from ..body import Body
from ..body.sensed import Sensed
from .actuators import ActuatorState
from .script_waits import cliff

Demo = Iterator[None]

SEAM = RED_BUOY | GREEN_BUOY
"""Both beams: straight ahead of a Home Base. Red is on the right of a robot that comes in."""
CRUISE, TURNING, CREEP = 140.0, 120.0, 100.0
"""Speeds: slow enough to stop between seeing an edge and dropping a wheel over it."""
SEARCH_SLOTS = 400
"""Slots without a beam after which the search for a Home Base ends."""
SEAM_TOLERANCE = 4.0
"""Degrees off the seam that are not corrected."""


class Controls:
    """The sensors, wheels and speaker as a demo uses them."""

    def __init__(self, body: Body, actuators: ActuatorState, random: Random) -> None:
        self._body, self._actuators = body, actuators
        self._separation = body.config.encoder_separation * MM_PER_M
        self.random = random

    @property
    def sense(self) -> Sensed:
        """The sensors in this slot."""
        return self._body.sense()

    @property
    def blocked(self) -> bool:
        """Something is ahead that a demo does not drive into."""
        sense = self.sense
        return sense.bump_left or sense.bump_right or sense.virtual_wall or cliff(sense)

    @property
    def beams(self) -> int:
        """The buoy beams of a Home Base that are seen: RED_BUOY, GREEN_BUOY, SEAM or 0."""
        seen = self.sense.infrared
        return seen & SEAM if BEAMS < seen < Infrared.NONE else 0

    @property
    def angle(self) -> float:
        """Degrees turned since the start."""
        return self._body.angle_total

    @property
    def distance(self) -> float:
        """Millimetres driven since the start."""
        return self._body.distance_total

    def drive(self, right: float, left: float) -> None:
        self._actuators.turn_wheels(WheelSpeeds(right, left))

    def curve(self, speed: float, radius: float) -> None:
        """Drive on a circle; a positive radius turns left."""
        outward = speed * self._separation / 2 / radius
        self.drive(speed + outward, speed - outward)


# Parts of demos.

def roll(controls: Controls, distance: float, speed: float = CRUISE) -> Demo:
    """Drive straight; a negative distance is backward, forward ends where something blocks."""
    start = controls.distance
    forward = distance > 0
    controls.drive(*(speed if forward else -speed,) * 2)
    while abs(controls.distance - start) < abs(distance):
        if forward and controls.blocked:
            return
        yield


def turn(controls: Controls, degrees: float, speed: float = TURNING) -> Demo:
    """Turn in place, counter-clockwise for a positive angle."""
    start = controls.angle
    sign = math.copysign(speed, degrees)
    controls.drive(sign, -sign)
    while abs(controls.angle - start) < abs(degrees):
        yield


def back_off(controls: Controls, least: float, most: float) -> Demo:
    """Go back a little and turn by a random angle away from the side that met something."""
    sense = controls.sense
    left = sense.bump_left or sense.cliff_left or sense.cliff_front_left
    right = sense.bump_right or sense.cliff_right or sense.cliff_front_right
    if left == right:
        left = controls.random.random() < 0.5
    yield from roll(controls, -60, CREEP)
    angle = controls.random.uniform(least, most)
    yield from turn(controls, -angle if left else angle)


def spiral(controls: Controls, first: float, last: float, pitch: float = 120.0) -> Demo:
    """Circle while the radius goes from `first` to `last`, until something blocks."""
    start = controls.angle
    step = math.copysign(pitch, last - first)
    radius = first
    while (radius - last) * step < 0:
        controls.curve(CRUISE, radius)
        yield
        if controls.blocked:
            return
        radius = first + step * (controls.angle - start) / 360


def follow_wall(controls: Controls, seconds: float) -> Demo:
    """Keep the wall on the right at an even distance; turn left where something blocks."""
    wanted = 1200
    for _ in range(round(seconds / SLOT)) if seconds < math.inf else iter(int, 1):
        if controls.blocked:
            yield from roll(controls, -40, CREEP)
            yield from turn(controls, 30)
        error = (controls.sense.wall_signal - wanted) / wanted
        bend = max(-0.6, min(0.4, 0.4 * error))
        controls.drive(TURNING * (1 + bend), TURNING * (1 - bend))
        yield


# The demos.

def cover(controls: Controls) -> Demo:
    """Cover a room: spiral, bounce at random, follow walls, and repeat."""
    while True:
        yield from spiral(controls, 100, 800)
        for _ in range(controls.random.randint(3, 6)):
            yield from roll(controls, 5000)
            yield from back_off(controls, 60, 170)
        yield from follow_wall(controls, 15)
        yield from turn(controls, controls.random.uniform(60, 120))
        yield from roll(controls, 500)


def cover_and_dock(controls: Controls) -> Demo:
    """Cover until a Home Base is seen, then dock with it."""
    while True:
        for _ in cover(controls):
            if controls.beams:
                break
            yield
        yield from dock(controls)
        if controls.sense.home_base:
            return
        # Leave the beams, or the next attempt starts where this one failed.
        yield from turn(controls, controls.random.uniform(90, 180))


def dock(controls: Controls) -> Demo:
    """
    Follow the seam between the two beams; end on the contacts, or when all beams are lost.

    Beside the seam the robot drives back to it on a circle that grows until it meets the seam.
    The direction of the seam is the mean of the headings at which a circle leaves and meets it.
    """
    lost, left_at = 0, controls.angle
    while lost < SEARCH_SLOTS and not controls.sense.home_base:
        beams, sense = controls.beams, controls.sense
        lost = 0 if beams else lost + 1
        if sense.bump_left or sense.bump_right:
            yield from roll(controls, -200, CREEP)
            if beams != SEAM:
                yield from back_off(controls, 60, 170)
                yield from roll(controls, 300)
        elif beams == SEAM:
            if abs(left_at - controls.angle) > SEAM_TOLERANCE:
                yield from turn(controls, (left_at - controls.angle) / 2, CREEP)
            left_at = controls.angle
            controls.drive(CREEP, CREEP)
        elif beams:
            radius = 150 + abs(controls.angle - left_at)
            controls.curve(CREEP, radius if beams == RED_BUOY else -radius)
        else:
            controls.drive(CREEP, -CREEP)
        yield


def spot_cover(controls: Controls) -> Demo:
    """Spiral outward, then inward."""
    yield from spiral(controls, 80, 500)
    yield from spiral(controls, 500, 80)


def mouse(controls: Controls) -> Demo:
    """Search for a wall, then follow it around the room."""
    while not (controls.blocked or controls.sense.wall):
        yield from roll(controls, 50)
    yield from follow_wall(controls, math.inf)


def figure_eight(controls: Controls) -> Demo:
    """Drive circles, left and right in turn."""
    while True:
        for side in (1, -1):
            start = controls.angle
            controls.curve(CRUISE, side * 300)
            while abs(controls.angle - start) < 360:
                if cliff(controls.sense):
                    return
                yield


DRIVING: dict[DemoNumber, Callable[[Controls], Demo]] = {
    DemoNumber.COVER: cover,
    DemoNumber.COVER_AND_DOCK: cover_and_dock,
    DemoNumber.SPOT_COVER: spot_cover,
    DemoNumber.MOUSE: mouse,
    DemoNumber.DRIVE_FIGURE_EIGHT: figure_eight,
}
"""The demos that drive; in the others, which are not simulated, the robot stands."""
NUMBERS: list[DemoNumber] = [demo for demo in DemoNumber if demo is not DemoNumber.ABORT]


ENDED = object()
"""Returned by `next` when a demo has ended."""


class DemoPlayer:
    """Runs one demo at a time."""

    def __init__(self, controls: Controls) -> None:
        self._controls = controls
        self.demo: DemoNumber | None = None
        """The demo that runs."""
        self._behaviour: Demo | None = None
        self.reset()

    def reset(self) -> None:
        self._selected = DemoNumber.COVER
        self._pressed = (False, False)
        self.stop()

    def start(self, demo: DemoNumber) -> None:
        """Start a demo in place of the one that runs."""
        self.stop()
        self.demo = demo
        if demo in DRIVING:
            self._behaviour = DRIVING[demo](self._controls)

    def stop(self) -> None:
        """End the demo that runs, if any, and stop the wheels."""
        if self.demo is not None:
            self._controls.drive(0, 0)
        self.demo = self._behaviour = None

    def step(self) -> None:
        if self._behaviour is not None and next(self._behaviour, ENDED) is ENDED:
            self.stop()

    def watch_buttons(self, sensed: Sensed, *, enabled: bool) -> None:
        """Look at the buttons: if enabled, Advance selects a demo, Play starts and stops it."""
        before, self._pressed = self._pressed, (sensed.play, sensed.advance)
        if not enabled:
            return
        if sensed.advance and not before[1]:
            self._selected = NUMBERS[(NUMBERS.index(self._selected) + 1) % len(NUMBERS)]
        if sensed.play and not before[0]:
            if self.demo is None:
                self.start(self._selected)
            else:
                self.stop()
