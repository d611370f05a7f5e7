# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_calibrate`: compute the parameters of the odometry from measured drives.

    create_calibrate line 2.000:1.984 2.000:1.986      metres, measured:reported
    create_calibrate turns 3600:3548 -3600:-3551       degrees, measured:reported
    create_calibrate square --side 2 --clockwise 0.05,-0.02 --counter 0.06,0.03

Reported values come from `odom`; `create_calibrate listen` adds them up while you drive.
"""

import argparse
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
import re
import sys

from ...ros.parameters import Parameters
from ...ros.whole_file import write_whole
from .calibration import Calibration, EndOffset, line, Run, square, turns
from .parameter_file import with_values

RESULTS = {'line': ('linear_scale',), 'turns': ('angular_scale', 'wheel_separation'),
           'square': ('angular_scale', 'wheel_separation')}
"""Parameters that each way of measuring finds."""


def _numbers(count: int, separator: str, form: str) -> Callable[[str], tuple[float, ...]]:
    """Return a function that reads finite numbers from an argument of this form."""
    def read(text: str) -> tuple[float, ...]:
        try:
            found = tuple(map(float, text.split(separator)))
        except ValueError:
            found = ()
        if len(found) != count or not all(map(isfinite, found)):
            raise argparse.ArgumentTypeError(f'{text.strip()!r}: give {form}, such as '
                                             f'{separator.join(["1.25"] * count)}')
        return found
    return read


_pair = _numbers(2, ':', 'MEASURED:REPORTED')
_point = _numbers(2, ',', 'X,Y in metres')
_metres = _numbers(1, ' ', 'a number of metres')


def _run(text: str) -> Run:
    return Run(*_pair(text))


def _offset(text: str) -> EndOffset:
    return EndOffset(*_point(text))


def _value_of(name: str) -> Callable[[str], float]:
    """Return a function that reads a value that the node takes for this parameter."""
    low, high = _range(name)
    form = f'a number from {low} to {high}'

    def read(text: str) -> float:
        value, = _numbers(1, ' ', form)(text.strip())
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f'{text.strip()!r}: give {form}')
        return value
    return read


def _range(name: str) -> tuple[float, float]:
    facts = Parameters.__dataclass_fields__[name].metadata
    return facts['low'], facts['high']


def _arguments() -> argparse.ArgumentParser:
    """Return the command's arguments."""
    parser = argparse.ArgumentParser(
        prog='create_calibrate', description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('-o', '--output', type=Path, metavar='FILE',
                        help='parameter file to write the values to; all else in it stays as it '
                        'is (default: print them)')
    for name, value in vars(Calibration()).items():
        parser.add_argument(
            f'--{name.replace("_", "-")}', type=_value_of(name), default=value,
            metavar='VALUE', help=f'value used during the drives (default {value})')
    ways = parser.add_subparsers(dest='way', required=True)
    for way, about in (('line', 'drives along a line, metres'),
                       ('turns', 'turns in place, degrees')):
        ways.add_parser(way, help=about).add_argument(
            'runs', type=_run, nargs='+', metavar='MEASURED:REPORTED')
    marks = ways.add_parser(
        'square', help='UMBmark: ends of square drives, measured less reported')
    marks.add_argument('--side', type=lambda text: _metres(text.strip())[0], required=True,
                       help='metres')
    for name in ('--clockwise', '--counter'):
        marks.add_argument(name, type=_offset, nargs='+', required=True, metavar='X,Y')
    ways.add_parser('listen', help='add up what odom reports while you drive',
                    epilog='A robot in a namespace: --ros-args -r __ns:=/robot1')
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


def _found(options: argparse.Namespace) -> dict[str, float]:
    """Return the values to set and print remarks; ValueError: they are not believable."""
    calibration, remarks = calibrated(options)
    print(*remarks, sep='\n', file=sys.stderr, end='\n' if remarks else '')
    values = {name: getattr(calibration, name) for name in RESULTS[options.way]}
    for name, value in values.items():
        low, high = _range(name)
        if not low <= value <= high:
            raise ValueError(f'{name} would be {value:.5f}; the node takes {low} to {high}: was '
                             'it set to another value during the drives?')
    return values


def _write(target: Path | None, values: dict[str, float]) -> None:
    """Write the values to a parameter file, or print one; ValueError, OSError: why not."""
    if target is None:
        print(with_values('', values), end='')
        return
    try:
        text = target.read_text('utf-8') if target.is_file() else ''
        content = with_values(text, values)
    except UnicodeDecodeError:
        raise ValueError(f'{target} is left as it is: it is no text') from None
    except ValueError as error:
        raise ValueError(f'{target} is left as it is: {error}') from error
    write_whole(target, content.encode())
    print(f'{target}: {", ".join(f"{name} {value:.5f}" for name, value in values.items())}; '
          f'start the node with --ros-args --params-file {target}')


def _signs_kept(arguments: Sequence[str]) -> list[str]:
    """Put a space before -3600:-3551 and the like, which argparse takes for options."""
    return [f' {each}' if re.match(r'-[.\d]', each) else each for each in arguments]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_calibrate`; 2: the values are not believable. OSError: not to be written."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    parser = _arguments()
    if '--ros-args' in given and 'listen' in given:
        from rclpy.utilities import remove_ros_args
        options = parser.parse_args(remove_ros_args(['', *given])[1:])
    else:
        options = parser.parse_args(_signs_kept(given))
    if options.way == 'listen':
        from .listen import listen
        return listen(['create_calibrate', *given])
    try:
        _write(options.output, _found(options))
    except ValueError as error:
        print(f'create_calibrate: {error}', file=sys.stderr)
        return 2
    return 0
