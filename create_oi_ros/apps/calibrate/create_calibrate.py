"""
`create_calibrate`: compute the parameters of the odometry from measured drives.

    create_calibrate line 2.000:1.984 2.000:1.986      metres, measured:reported
    create_calibrate turns 3600:3548                   degrees, measured:reported
    create_calibrate square --side 2 --clockwise 0.05,-0.02 --counter 0.06,0.03

Reported values come from `odom`; `create_calibrate listen` adds them up while you drive.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from .calibration import Calibration, EndOffset, line, Run, square, turns


def _run(text: str) -> Run:
    try:
        measured, reported = map(float, text.split(':'))
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r}: give MEASURED:REPORTED') from None
    return Run(measured, reported)


def _offset(text: str) -> EndOffset:
    try:
        x, y = map(float, text.split(','))
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r}: give X,Y in metres') from None
    return EndOffset(x, y)


def _arguments() -> argparse.ArgumentParser:
    """Return the command's arguments."""
    parser = argparse.ArgumentParser(
        prog='create_calibrate', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('-o', '--output', type=Path, help='YAML file to write; default: print it')
    for name, value in vars(Calibration()).items():
        parser.add_argument(
            f'--{name.replace("_", "-")}', type=float, default=value,
            help=f'value used during the drives (default {value})')
    ways = parser.add_subparsers(dest='way', required=True)
    for way, about in (('line', 'drives along a line, metres'),
                       ('turns', 'turns in place, degrees')):
        ways.add_parser(way, help=about).add_argument(
            'runs', type=_run, nargs='+', metavar='MEASURED:REPORTED')
    marks = ways.add_parser(
        'square', help='UMBmark: ends of square drives, measured less reported')
    marks.add_argument('--side', type=float, required=True, help='metres')
    for name in ('--clockwise', '--counter'):
        marks.add_argument(name, type=_offset, nargs='+', required=True, metavar='X,Y')
    ways.add_parser('listen', help='add up what odom reports while you drive')
    return parser


def calibrated(options: argparse.Namespace) -> tuple[Calibration, list[str]]:
    """Return the new values and remarks for the user; ValueError: not believable."""
    before = Calibration(
        options.linear_scale, options.angular_scale, options.wheel_separation)
    if options.way == 'line':
        return line(options.runs, before), []
    if options.way == 'turns':
        return turns(options.runs, before), []
    found = square(options.clockwise, options.counter, options.side, before)
    return found.calibration, [
        f'UMBmark: the robot came back to within {found.worst:.3f} m',
        f'right wheel over left wheel: {found.wheel_ratio:.5f} (no parameter corrects this)']


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_calibrate`; 2: the values are not believable."""
    options = _arguments().parse_args(arguments)
    if options.way == 'listen':
        from .listen import listen
        return listen()
    try:
        calibration, remarks = calibrated(options)
    except ValueError as error:
        print(f'create_calibrate: {error}', file=sys.stderr)
        return 2
    print(*remarks, sep='\n', file=sys.stderr, end='\n' if remarks else '')
    if options.output is None:
        print(calibration.yaml(), end='')
        return 0
    options.output.write_text(calibration.yaml())
    print(f'{options.output} written; start the node with --ros-args --params-file '
          f'{options.output}')
    return 0
