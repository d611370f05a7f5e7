# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a person at the robot is asked during a check, and what only a person can see."""

from contextlib import suppress
from math import isfinite
import sys

from ... import oi
from ...driver.battery import charges
from .robot_line import RobotLine
from .verdict import banner_in, Finding

BOOT = 8.0
"""Seconds in which a robot that is switched on says its banner, and answers."""
DOCKED = 5.0
"""Seconds in Passive on the dock in which charging begins, if it does."""
UNDEFINED_LEDS = bytes([oi.Leds.opcode, 25, 0, 128])
"""LEDs with two bits that mean something, 2 and 8, and two that do not, 1 and 16."""
LEDS_RESTORED = bytes([oi.Leds.opcode, 0, 0, 0])


class Person:
    """Who watches the robot; with `--yes` nobody does."""

    def __init__(self, *, absent: bool) -> None:
        self.absent = absent

    def confirm(self, text: str) -> None:
        """Wait until the person has read a text and pressed Enter."""
        if self.absent:
            print(text, flush=True)
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
    restarted = line.health().counts.silences > 0
    return found if restarted else not_seen


def about_dock(line: RobotLine) -> Finding:
    """Say what the robot does on its dock, if it stands there."""
    readings = line.health().readings
    if not readings.has('charging_sources') or not readings.charging_sources:
        return Finding('Passive on the dock', 'not looked at: it was not on its dock',
                       'nothing')
    line.enter(oi.Mode.PASSIVE)
    charging = line.until(lambda health: health.readings.has('charging_state')
                          and charges(health.readings), DOCKED)
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


def tell(text: str) -> None:
    """Print a line at once."""
    print(text, flush=True)


def progress(done: int, of: int) -> None:
    """Show how far a step has come, on a terminal."""
    if sys.stdout.isatty():
        print(f'\r  {done} of {of}', end='\n' if done == of else '', flush=True)
