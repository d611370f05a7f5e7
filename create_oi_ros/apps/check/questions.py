# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a person at the robot is asked during a check: what only a person can see or measure.

What a tape measure says becomes the driver's parameters `linear_scale` and `angular_scale` (true
motion over reported motion) and `wheel_separation`, which changes as one over the angle: a robot
that turns further than it reports has wheels that are closer together than assumed.
"""

from contextlib import suppress
from functools import partial
from math import degrees, isfinite, tau

from ... import oi
from ...driver.battery import charges
from ...robot import MILLI, WHEEL_SEPARATION
from .moves import Move, Reads, Segment
from .robot_line import RobotLine
from .verdict import banner_in, Finding

BOOT = 8.0
"""Seconds in which a robot that is switched on says its banner, and answers."""
DOCKED = 5.0
"""Seconds in Passive on the dock in which charging begins, if it does."""
UNDEFINED_LEDS = bytes([oi.Leds.opcode, 25, 0, 128])
"""LEDs with two bits that mean something, 2 and 8, and two that do not, 1 and 16."""
LEDS_RESTORED = bytes([oi.Leds.opcode, 0, 0, 0])
SPEED = 200
"""mm/s of each wheel, where a tape measure follows."""
TURNS = 3
AHEAD = Move((Segment(5.0, SPEED, SPEED),), Reads.END)
BACK = Move((Segment(5.0, -SPEED, -SPEED),), Reads.END)
TURNING = TURNS * tau * WHEEL_SEPARATION / (2 * SPEED * MILLI)
"""Seconds that the turns take."""
SIDES = {'left': Move((Segment(TURNING, SPEED, -SPEED),), Reads.END),
         'right': Move((Segment(TURNING, -SPEED, SPEED),), Reads.END)}
PLAUSIBLE = 0.2
"""Largest correction that is believed; a larger one is a mistake in measuring."""
tell = partial(print, flush=True)


class Person:
    """Who watches the robot; with `--yes` nobody does."""

    def __init__(self, *, absent: bool) -> None:
        self.absent = absent

    def confirm(self, text: str) -> None:
        """Wait until the person has read a text and pressed Enter."""
        if self.absent:
            tell(text)
        else:
            self._ask(f'{text} - Enter: ')

    def sees(self, text: str) -> bool | None:
        """Ask a question; None: the person does not know."""
        if self.absent:
            return None
        return {'y': True, 'n': False}.get(self._ask(f'{text} - y, n, or Enter: ')[:1].lower())

    def number(self, text: str) -> float | None:
        """Ask for a number until one is given; None: the person does not know."""
        while answer := self._ask(f'{text} - a number, or Enter: '):
            with suppress(ValueError):
                if isfinite(number := float(answer.replace(',', '.'))):
                    return number
            tell(f'{answer!r} is no number')
        return None

    def _ask(self, text: str) -> str:
        try:
            return input(text).strip()
        except EOFError:
            raise KeyboardInterrupt from None


def about_banner(line: RobotLine, person: Person) -> Finding:
    """Let the robot be switched off and on; say what it says."""
    not_seen = Finding('banner', 'not looked at', 'nothing')
    if person.absent:
        return not_seen
    line.heard.clear()
    person.confirm('Switch the robot off and on again, if you want to know what it says then')
    line.until(lambda health: health.answered, BOOT)
    found = banner_in(bytes(line.heard))
    restarted = line.session.health().counts.silences > 0
    return found if restarted else not_seen


def about_dock(line: RobotLine) -> Finding:
    """Say what the robot does on its dock, if it stands there."""
    readings = line.session.health().readings
    if not readings.charging_sources:
        return Finding('Passive on the dock', 'not looked at: it was not on its dock',
                       'nothing')
    line.enter(oi.Mode.PASSIVE)
    charging = line.until(lambda health: charges(health.readings), DOCKED)
    safe = line.enter(oi.Mode.SAFE)
    answer = 'charging begins' if charging else f'no charging within {DOCKED:.0f} s'
    answer += ('; on the dock it enters Safe' if safe.ok
               else '; on the dock it does not stay in Safe')
    return Finding('Passive on the dock', answer,
                   'the manual' if charging else 'reports of Create robots on TurtleBots')


def about_leds(line: RobotLine, person: Person) -> Finding:
    """Say what becomes of bits of LEDs that mean nothing."""
    if person.absent:
        return Finding('LED masks', 'not looked at', 'nothing')
    line.send_raw(UNDEFINED_LEDS)
    lit = person.sees('Do both Play and Advance light now?')
    line.send_raw(LEDS_RESTORED)
    if lit is None:
        return Finding('LED masks', 'not seen', 'nothing')
    return Finding('LED masks', 'bits that mean nothing are left out' if lit else
                   'a command with bits that mean nothing is ignored',
                   'reports of real robots' if lit else 'the manual, read strictly')


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
    before, _ = line.notebook.estimate.trip
    if not line.make(AHEAD):
        tell(f'Not measured: {line.runner.disturbance}')
        return None
    reported = line.notebook.estimate.trip[0] - before
    scale = _corrected(person, 'How many metres did it come?', reported)
    person.confirm('It drives back')
    line.make(BACK)
    return scale


def _angle(line: RobotLine, person: Person) -> float | None:
    """Return true over reported angle, of both directions; None: it was not measured."""
    measured = reported = 0.0
    for side, move in SIDES.items():
        person.confirm(f'Mark where the robot looks. It turns {TURNS} times to the {side}')
        _, before = line.notebook.estimate.trip
        if not line.make(move):
            tell(f'Not measured: {line.runner.disturbance}')
            return None
        turned = abs(degrees(line.notebook.estimate.trip[1] - before))
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
