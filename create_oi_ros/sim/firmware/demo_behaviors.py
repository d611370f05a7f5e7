# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The ten demos as recognisable behaviours of a few lines each; not iRobot's own programs.

A demo is a generator. It reads `Controls`, sets the wheels and yields until the next slot. It ends
when it returns, or is aborted when it is dropped. Speeds are in mm/s, distances in mm, angles in
degrees counter-clockwise.
"""

from collections.abc import Callable, Iterator, Sequence
import math
from random import Random

from ...oi import DemoNumber, Infrared, Note
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
PACHELBEL = (78, 76, 74, 73, 71, 69, 71, 73, 74, 73, 71, 69, 67, 66, 67, 64)
"""The Canon's first violin, its first sixteen notes (MIDI numbers)."""
G_MAJOR, D_MAJOR_7, C_MAJOR = (55, 59, 62, 67), (62, 66, 69, 73), (60, 64, 67, 72)
"""Banjo's chords, one note for each cliff sensor from left to right."""
SEARCH_SLOTS = 400
"""Slots without a beam after which the search for a Home Base ends."""
SEAM_TOLERANCE = 4.0
"""Degrees off the seam that are not corrected."""
NOTE_LENGTH = 20
"""64ths of a second."""


class Controls:
    """The sensors, wheels and speaker as a demo uses them."""

    def __init__(self, body: Body, actuators: ActuatorState, random: Random,
                 sound: Callable[[Sequence[Note]], None]) -> None:
        self._body, self._actuators = body, actuators
        self._separation = body.config.encoder_separation * MM_PER_M
        self.random = random
        self.sound = sound

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

def wait(seconds: float) -> Demo:
    """Keep the present wheel speeds."""
    for _ in range(round(seconds / SLOT)):
        yield


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
        beams = controls.beams
        lost = 0 if beams else lost + 1
        if _bumped(controls):
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


def wimp(controls: Controls) -> Demo:
    """Drive forward when pushed from behind; turn away from an obstacle."""
    while True:
        controls.drive(0, 0)
        yield from wait(0.5)
        start = controls.distance
        while controls.distance - start < 5:
            yield
        yield from roll(controls, 500)
        if controls.blocked:
            yield from roll(controls, -100)
            yield from turn(controls, controls.random.choice((-1, 1)) * 150)
            yield from roll(controls, 300)


def home(controls: Controls) -> Demo:
    """Spin to find a virtual wall, drive towards it, stop at the first obstacle."""
    yield from _seek(controls)
    controls.drive(0, 0)


def tag(controls: Controls) -> Demo:
    """Do as in Home, then turn around and look for the next virtual wall."""
    while True:
        yield from _seek(controls)
        yield from roll(controls, -100)
        yield from turn(controls, 180)
        # The wall just tagged is still seen here: leave it, then look for another.
        for wanted in (True, False):
            start = controls.distance
            controls.drive(CRUISE, CRUISE)
            while (controls.sense.virtual_wall is wanted and controls.distance - start < 3000
                   and not _stopped(controls)):
                yield


def _stopped(controls: Controls) -> bool:
    return _bumped(controls) or cliff(controls.sense)


def _bumped(controls: Controls) -> bool:
    return controls.sense.bump_left or controls.sense.bump_right


def _seek(controls: Controls) -> Demo:
    """Spin until a virtual wall is seen, drive while it is; end at a bump or a cliff."""
    while not _stopped(controls):
        if controls.sense.virtual_wall:
            controls.drive(CRUISE, CRUISE)
        else:
            controls.drive(CREEP, -CREEP)
        yield


def pachelbel(controls: Controls) -> Demo:
    """Play the next note of the Canon when a cliff sensor starts to see a cliff."""
    place = 0
    for fresh in _fresh_cliffs(controls):
        if any(fresh):
            controls.sound((Note(PACHELBEL[place], NOTE_LENGTH),))
            place = (place + 1) % len(PACHELBEL)
        yield


def banjo(controls: Controls) -> Demo:
    """Play a note when a cliff sensor starts to see a cliff; the bumper sets the chord."""
    for fresh in _fresh_cliffs(controls):
        sense = controls.sense
        chord = (C_MAJOR if sense.bump_left and sense.bump_right
                 else D_MAJOR_7 if sense.bump_left or sense.bump_right else G_MAJOR)
        notes = [Note(number, NOTE_LENGTH) for number, new in zip(chord, fresh, strict=True)
                 if new]
        if notes:
            controls.sound(notes)
        yield


def _fresh_cliffs(controls: Controls) -> Iterator[tuple[bool, ...]]:
    """Yield in each slot which of the four sensors sees a cliff and did not before."""
    before = (False,) * 4
    while True:
        sense = controls.sense
        now = (sense.cliff_left, sense.cliff_front_left,
               sense.cliff_front_right, sense.cliff_right)
        yield tuple(new and not old for new, old in zip(now, before, strict=True))
        before = now


DEMOS: dict[DemoNumber, Callable[[Controls], Demo]] = {
    DemoNumber.COVER: cover,
    DemoNumber.COVER_AND_DOCK: cover_and_dock,
    DemoNumber.SPOT_COVER: spot_cover,
    DemoNumber.MOUSE: mouse,
    DemoNumber.DRIVE_FIGURE_EIGHT: figure_eight,
    DemoNumber.WIMP: wimp,
    DemoNumber.HOME: home,
    DemoNumber.TAG: tag,
    DemoNumber.PACHELBEL: pachelbel,
    DemoNumber.BANJO: banjo,
}


ENDED = object()
"""Returned by `next` when a demo has ended."""


class DemoPlayer:
    """Runs one demo at a time."""

    __slots__ = ('demo', '_behaviour', '_controls', '_selected', '_pressed')

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
        self._behaviour = DEMOS[demo](self._controls)

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
            numbers = list(DEMOS)
            self._selected = numbers[(numbers.index(self._selected) + 1) % len(numbers)]
        if sensed.play and not before[0]:
            if self.demo is None:
                self.start(self._selected)
            else:
                self.stop()
