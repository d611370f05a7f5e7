# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `create_report`: make one page from a bag."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
import sys

from .page import write
from .recording import read

WIDTH = 30
"""Characters of the progress bar."""


def bar(label: str) -> Callable[[float], None]:
    """Return a function that draws a progress bar on stderr, if that is a terminal."""
    def show(part: float) -> None:
        done = round(WIDTH * min(1.0, max(0.0, part)))
        end = '\n' if part >= 1 else ''
        print(f'\r{label} [{"#" * done}{"." * (WIDTH - done)}] {min(1.0, part):4.0%}',
              end=end, file=sys.stderr, flush=True)
    return show if sys.stderr.isatty() else lambda part: None


def _target(text: str) -> Path:
    target = Path(text)
    if target.suffix != '.html':
        raise argparse.ArgumentTypeError(f'{text!r} must end in .html: the report is a page')
    return target


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_report`; BagError or OSError says why no report can be made."""
    parser = argparse.ArgumentParser(
        prog='create_report', description='Show on one page what a robot did, from a bag.')
    parser.add_argument('bag', type=Path, metavar='BAG',
                        help='folder of a bag, or one of its files')
    parser.add_argument('-o', dest='target', type=_target, default=Path('report.html'),
                        metavar='FILE.html', help='the page (default: %(default)s)')
    parser.add_argument('--robot', metavar='NAMESPACE',
                        help='which robot, if the bag holds several; / is one without a namespace')
    options = parser.parse_args(arguments)
    write(read(options.bag, bar(f'reading {options.bag.name}'), options.robot), options.target)
    print(options.target)
    return 0
