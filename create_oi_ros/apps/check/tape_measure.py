# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What only a tape measure tells: how far the robot really came, and how far it turned.

The answers become the driver's parameters `linear_scale` and `angular_scale` (true motion over
reported motion) and `wheel_separation`, which changes as one over the angle: a robot that turns
further than it reports has wheels that are closer together than assumed.
"""

from math import degrees, tau

from ...robot import MILLI, WHEEL_SEPARATION
from .moves import Move, Reads, Segment
from .questions import Person, tell
from .robot_line import RobotLine

SPEED = 200
"""mm/s of each wheel."""
TURNS = 3
AHEAD = Move((Segment(5.0, SPEED, SPEED),), Reads.END)
BACK = Move((Segment(5.0, -SPEED, -SPEED),), Reads.END)
TURNING = TURNS * tau * WHEEL_SEPARATION / (2 * SPEED * MILLI)
"""Seconds that the turns take."""
SIDES = {'left': Move((Segment(TURNING, SPEED, -SPEED),), Reads.END),
         'right': Move((Segment(TURNING, -SPEED, SPEED),), Reads.END)}
PLAUSIBLE = 0.2
"""Largest correction that is believed; a larger one is a mistake in measuring."""


def by_tape(line: RobotLine, person: Person) -> dict[str, float]:
    """Drive, ask what the tape measure says, and return the parameters that follow from it."""
    if person.absent or not person.sees(
            'Have you a tape measure? Then the driver can count true metres and degrees'):
        return {}
    found = {}
    if (scale := _distance(line, person)) is not None:
        found['linear_scale'] = scale
    if (scale := _angle(line, person)) is not None:
        found |= {'angular_scale': scale, 'wheel_separation': WHEEL_SEPARATION / scale}
    return found


def in_lines(found: dict[str, float]) -> list[str]:
    """Return what to put into a parameter file."""
    return ['For your parameter file (--params-file), below ros__parameters:',
            *(f'    {name}: {value:.4f}' for name, value in found.items())] if found else []


def _distance(line: RobotLine, person: Person) -> float | None:
    """Return true over reported distance; None: it was not measured."""
    person.confirm('Mark where the front of the robot is. It drives a metre straight ahead')
    before = line.notebook.travelled
    if not line.make(AHEAD):
        tell(f'Not measured: {line.runner.disturbance}')
        return None
    reported = line.notebook.travelled - before
    scale = _corrected(person, 'How many metres did it come?', reported)
    person.confirm('It drives back')
    line.make(BACK)
    return scale


def _angle(line: RobotLine, person: Person) -> float | None:
    """Return true over reported angle, of both directions; None: it was not measured."""
    measured = reported = 0.0
    for side, move in SIDES.items():
        person.confirm(f'Mark where the robot looks. It turns {TURNS} times to the {side}')
        before = line.notebook.turned
        if not line.make(move):
            tell(f'Not measured: {line.runner.disturbance}')
            return None
        turned = abs(degrees(line.notebook.turned - before))
        scale = _corrected(
            person, f'By how many degrees did it turn beyond the mark, to the {side}? '
            'Negative: it stands before it', turned, 360 * round(turned / 360))
        if scale is None:
            return None
        measured, reported = measured + scale * turned, reported + turned
    return measured / reported


def _corrected(person: Person, question: str, reported: float, whole: int = 0) -> float | None:
    """Ask until `whole` and the answer over `reported` is believable; None: not measured."""
    while (told := person.number(question)) is not None:
        scale = (whole + told) / reported
        if abs(scale - 1) <= PLAUSIBLE:
            return scale
        tell(f'That would be a correction by {scale:.2f}; allowed is up to {PLAUSIBLE:.0%}. Is it '
             'in the right unit, with the right sign?')
    return None
