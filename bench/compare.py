# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compare two sets of results: `python bench/compare.py [OLD.json] [NEW.json]`.

Without file names it compares the committed `bench/results.json` with the one in the working tree.
Compare ratios to the floor: node and floor were measured together. Absolute times say little when
the two runs were on different machines or on a busy one.
"""

import json
from pathlib import Path
import subprocess
import sys
from typing import Any

from results import figures_of, load, RESULTS


def committed() -> dict[str, Any]:
    """Return the results of the last commit."""
    shown = subprocess.run(
        ['git', 'show', f'HEAD:./{RESULTS.name}'], cwd=RESULTS.parent, check=True,
        capture_output=True, text=True)
    return json.loads(shown.stdout)


def compared(program: str, old: dict[str, Any], new: dict[str, Any]) -> list[list[str]]:
    """Return a table of one program's figures, old and new, heading first."""
    befores = {figure.what: figure for figure in figures_of(old, program)}
    table = [[program, 'before', 'now', 'change', 'target']]
    for figure in figures_of(new, program):
        before = befores.get(figure.what)
        was = '-' if before is None else f'{before.value:.4g} {before.unit}'
        change = '' if before is None or not before.value else (
            f'{100 * (figure.value / before.value - 1):+.0f} %')
        table.append([figure.what, was, f'{figure.value:.4g} {figure.unit}', change,
                      figure.verdict])
    return table


def main() -> None:
    """Print a table for each program that both files have."""
    old = load(Path(sys.argv[1])) if sys.argv[1:] else committed()
    new = load(Path(sys.argv[2])) if sys.argv[2:] else load()
    for program in new:
        if program not in old:
            continue
        print(f'{old[program]["where"]["date"]} -> {new[program]["where"]["date"]}')
        table = compared(program, old, new)
        widths = [max(map(len, column)) for column in zip(*table)]
        for row in table:
            print('  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())
        print()


if __name__ == '__main__':
    main()
