"""
Measured numbers: a table for the eye, and `bench/results.json` to compare with and to document.

Every bench program measures a list of figures and hands it to `run`. The file keeps the figures
of each program with when and where they were measured; the rest of the file stays.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Sequence
from datetime import datetime, UTC
import json
import os
from pathlib import Path
import platform
from statistics import median
from time import monotonic, sleep
from typing import Any, NamedTuple

from processes import machine_seconds

RESULTS = Path(__file__).with_name('results.json')


class Figure(NamedTuple):
    """One measured number, and the least or the most it may be."""

    what: str
    value: float
    unit: str
    target: float | None = None
    at_least: bool = False
    worst: float | None = None
    """Of the repetitions whose median the value is."""
    beside: str = ''
    """The absolute numbers behind a ratio."""

    @property
    def verdict(self) -> str:
        """Whether the target was met, or ''."""
        if self.target is None:
            return ''
        met = self.value >= self.target if self.at_least else self.value <= self.target
        return 'met' if met else 'missed'


def repeated(what: str, values: Sequence[float], unit: str, target: float | None = None,
             beside: str = '') -> Figure:
    """Return the median of repetitions, with the worst beside it: less is better."""
    return Figure(what, median(values), unit, target, worst=max(values), beside=beside)


def load_before(seconds: float = 1.0) -> float:
    """Return how many cores others keep busy; the system's average lags behind by a minute."""
    begun, used = monotonic(), machine_seconds()
    sleep(seconds)
    return (machine_seconds() - used) / (monotonic() - begun)


def machine() -> dict[str, Any]:
    """Say where this is measured."""
    models = [line.partition(':')[2].strip() for line in Path('/proc/cpuinfo').read_text().split(
        '\n') if line.startswith('model name')]
    return {
        'date': datetime.now(UTC).isoformat(timespec='minutes'),
        'processor': models[0] if models else platform.machine(), 'cores': os.cpu_count(),
        'load before': round(load_before(), 1), 'system': platform.system(),
        'python': platform.python_version()}


def rows(figures: Sequence[Figure]) -> list[list[str]]:
    """Return a table, its heading first."""
    table = [['what', 'value', 'worst', 'target', '', 'beside']]
    for figure in figures:
        worst = '' if figure.worst is None else f'{figure.worst:.4g}'
        bound = '' if figure.target is None else f'{">=" if figure.at_least else "<="} '
        target = '' if figure.target is None else f'{bound}{figure.target:g}'
        table.append([figure.what, f'{figure.value:.4g} {figure.unit}', worst, target,
                      figure.verdict, figure.beside])
    return table


def load(path: Path = RESULTS) -> dict[str, Any]:
    """Return the results of a file, by program; {} where there is none."""
    return json.loads(path.read_text('utf-8')) if path.exists() else {}


def figures_of(results: dict[str, Any], program: str) -> list[Figure]:
    """Return the figures of a program."""
    return [Figure(**each) for each in results[program]['figures']]


def keep(program: str, figures: Sequence[Figure], where: dict[str, Any],
         path: Path = RESULTS) -> None:
    """Put a program's figures in the place of those before them."""
    results = load(path)
    results[program] = {'where': where, 'figures': [figure._asdict() for figure in figures]}
    path.write_text(json.dumps(results, indent=1) + '\n', 'utf-8')


def run(program: str, measure: Callable[[], list[Figure]]) -> None:
    """Be a bench program: measure, print, keep."""
    parser = ArgumentParser(prog=f'bench/{program}.py')
    parser.add_argument('--json', type=Path, default=RESULTS, metavar='FILE',
                        help='keep the figures here (default: %(default)s)')
    path = parser.parse_args().json
    where = machine()
    print(f'{program}: ' + ', '.join(f'{name} {value}' for name, value in where.items()))
    figures = measure()
    table = rows(figures)
    widths = [max(map(len, column)) for column in zip(*table)]
    for row in table:
        print('  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())
    print()
    keep(program, figures, where, path)
