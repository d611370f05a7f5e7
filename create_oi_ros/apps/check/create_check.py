# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_check`: how a robot drives and counts, found in five guided minutes.

The robot stands on the floor. It makes short moves, each back to where it began; a person confirms
each step before. The answer is printed, and written as a file for the parameter `odometry_model`,
beside a capture of all bytes.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
import signal
import sys

from ... import oi
from ...driver import Health
from ...ros.odometry_model import write
from ...ros.parameters import BAUDS, Parameters
from ...ros.process import STOP_SIGNALS
from ...ros.programs import INTERRUPTED, UserError
from .moves import Move, Reads, Segment, STEPS
from .questions import (
    about_banner,
    about_dock,
    about_leds,
    by_tape,
    in_lines,
    Person,
    tell,
)
from .robot_line import RobotLine
from .verdict import as_mapping, Finding, lines, of_gyro, of_wheels

INTRODUCTION = """\
A robot answers. It makes short moves, about five minutes in all, each of them back to where it
began. It needs a hard, level floor with 1.2 m free ahead of it, 0.6 m behind it and 0.5 m to each
side, and no stairs. It is in Safe mode: it stops at cliffs, but not at walls. Ctrl-C stops the
wheels."""
ATTEMPTS = 3
"""How often a disturbed move is tried where nobody is there to ask."""
OFF_THE_DOCK = Move((Segment(2.5, -150, -150),), Reads.END)


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='create_check', description='Find out how a robot drives and counts, in five guided '
        'minutes. No driver may run at its port meanwhile.')
    parser.add_argument('port', nargs='?', default=Parameters.port,
                        help=f'serial device of the robot, or socket://HOST:PORT (default '
                             f'{Parameters.port})')
    parser.add_argument('--baud', type=int, default=Parameters.baud, choices=(0, *BAUDS),
                        help='bit/s; 0: look for the rate')
    parser.add_argument('-o', dest='output', type=Path, metavar='FILE',
                        default=Path('robot.yaml'), help='file for the verdict, for the parameter '
                        'odometry_model (default: robot.yaml)')
    parser.add_argument('--capture', metavar='FILE', default='robot-check.capture',
                        help='file for all bytes, to send; where it exists, a number is added to '
                             'its name (default: robot-check.capture)')
    parser.add_argument('--yes', action='store_true',
                        help='ask nobody: for a simulated robot')
    return parser


def _guide(line: RobotLine, person: Person) -> tuple[list[Finding], Health, dict[str, float]]:
    """Ask and drive; return what was seen, the health, parameters. UserError: why not."""
    seen = [about_banner(line, person), about_dock(line)]
    _to_the_floor(line, person)
    seen.append(about_leds(line, person))
    for number, step in enumerate(STEPS, 1):
        seconds = sum(move.seconds for move in step.moves)
        person.confirm(f'Step {number} of {len(STEPS)} ({seconds:.0f} s): {step.about}')
        for done, move in enumerate(step.moves, 1):
            _make(move, line, person)
            if sys.stdout.isatty():
                print(f'\r  {done} of {len(step.moves)}',
                      end='\n' if done == len(step.moves) else '', flush=True)
    return seen, line.session.health(), by_tape(line, person)


def _to_the_floor(line: RobotLine, person: Person) -> None:
    """See that the robot stands on the floor, in Safe mode."""
    outcome = line.enter(oi.Mode.SAFE)
    if line.session.health().readings.charging_sources:
        if person.absent:
            tell('It backs off its dock.')
            line.make(OFF_THE_DOCK)
        else:
            person.confirm('Take the robot off its dock, and put it on the floor')
        outcome = line.enter(oi.Mode.SAFE)
    while not outcome.ok:
        if person.absent:
            raise UserError(outcome.text)
        person.confirm(f'{outcome.text}. Mend this')
        outcome = line.enter(oi.Mode.SAFE)


def _make(move: Move, line: RobotLine, person: Person) -> None:
    """Make a move, again where it was disturbed."""
    for _ in range(ATTEMPTS if person.absent else 10 ** 6):
        if line.make(move):
            return
        why = line.runner.disturbance
        person.confirm(f'\nThe robot stands: {why}. Put it back; the move is repeated')
        line.enter(oi.Mode.SAFE)
    raise UserError(f'the robot cannot make its moves: {line.runner.disturbance}')


def _conclude(seen: Sequence[Finding], health: Health, output: Path) -> None:
    """Print what the odometry has learned and write it; OSError: it cannot be written."""
    if health.robot is None:
        raise UserError('nothing was learned: the robot never reported that it moved')
    findings = [*of_wheels(health.robot, health.checksum), of_gyro(health), *seen]
    tell('\n' + '\n'.join(lines(findings)) + '\n')
    write(output, health.robot, as_mapping(findings))
    tell(f'{output}: give it to the driver with -p odometry_model:={output.absolute()}')


def main() -> int:
    """Run `create_check`; 130: it was interrupted. UserError, OSError: what is wrong."""
    options = _arguments().parse_args()
    if not options.output.absolute().parent.is_dir():
        raise UserError(f'{options.output.absolute().parent} is no folder: nothing can be '
                        'written there')
    for number in STOP_SIGNALS:
        signal.signal(number, signal.default_int_handler)
    person = Person(absent=options.yes)
    try:
        line = RobotLine(options.port, options.baud, options.capture)
        with line.open():
            tell(f'Looking for a robot at {options.port} ...')
            line.wait_for_robot()
            person.confirm(INTRODUCTION)
            seen, health, parameters = _guide(line, person)
        _conclude(seen, health, options.output)
        tell('\n'.join(in_lines(parameters)))
        tell(f'{line.capture.path}: all bytes of the check; send both files if something looks '
             'wrong')
    except KeyboardInterrupt:
        print('\ncreate_check: interrupted; the wheels stand', file=sys.stderr)
        return INTERRUPTED
    return 0
