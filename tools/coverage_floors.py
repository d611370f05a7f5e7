# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compare the coverage of each room with its floor: `python tools/coverage_floors.py`.

It reads `.coverage`. The floors are in pyproject.toml, under `[tool.coverage-floors]`. The exit
code is 1 if a room is below its floor. A floor may only rise: the table shows where it can.
"""

from io import StringIO
from math import floor
from pathlib import Path
import sys
import tomllib
from typing import NamedTuple

from coverage import Coverage

PROJECT = Path(__file__).parents[1] / 'pyproject.toml'


class Room(NamedTuple):
    """A folder, its coverage of lines and branches in per cent, and its floor."""

    name: str
    covered: float
    floor: float
    missing: str
    """Report of the files that are not fully covered."""

    @property
    def verdict(self) -> str:
        """What the table says about the floor."""
        if self.covered < self.floor:
            return 'too low'
        # Rounded down, so that the new floor is not above what was measured.
        reached = floor(10 * self.covered) / 10
        return f'raise the floor to {reached:g}' if reached > self.floor else ''


def floors() -> dict[str, float]:
    """Return the floor of each room, in per cent."""
    return dict(tomllib.loads(PROJECT.read_text('utf-8'))['tool']['coverage-floors'])


def room(coverage: Coverage, name: str, lowest: float) -> Room:
    """Return the coverage of a room from measured coverage."""
    report = StringIO()
    covered = coverage.report(include=f'{name}/*', file=report)
    return Room(name, covered, lowest, report.getvalue())


def table(rooms: list[Room]) -> str:
    """Return the table that is printed last."""
    lines = [('coverage, lines and branches', '%', 'floor', ''),
             *((each.name, f'{each.covered:.2f}', f'{each.floor:g}', each.verdict)
               for each in rooms)]
    width = max(len(line[0]) for line in lines)
    return '\n'.join(f'{name:{width}} {covered:>7} {lowest:>6}  {verdict}'.rstrip()
                     for name, covered, lowest, verdict in lines)


def main() -> int:
    """Print the table, after the lines that are missing in rooms below their floor."""
    coverage = Coverage()
    coverage.load()
    rooms = [room(coverage, name, lowest) for name, lowest in floors().items()]
    low = [each for each in rooms if each.covered < each.floor]
    for each in low:
        print(each.missing)
    print(table(rooms))
    return int(bool(low))


if __name__ == '__main__':
    sys.exit(main())
