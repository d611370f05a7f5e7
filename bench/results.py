# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Measured figures: printed as a table and saved in `bench/results.json`.

Every bench program passes a function that returns its figures to `run`. The file has one entry for
each program: its figures, and when and on what machine they were measured. A run replaces the
entry of its program only. `document.py` reads the file.
"""

from collections.abc import Callable, Sequence
from datetime import datetime, UTC
import json
import os
from pathlib import Path
import platform
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from create_oi_ros.oi.tools.tables import columns

RESULTS = Path(__file__).with_name('results.json')


class Figure(NamedTuple):
    """One measured number and its target."""

    what: str
    value: float
    unit: str
    target: float | None = None
    """The most that is wanted."""
    worst: float | None = None
    """The worst of the repetitions; the value is their median."""
    beside: str = ''
    """More numbers for the reader, such as the absolute ones behind a ratio."""

    @property
    def missed(self) -> bool:
        """Whether there is a target, and it was missed."""
        return self.target is not None and self.value > self.target


def repeated(what: str, values: Sequence[float], unit: str, target: float | None = None,
             beside: str = '') -> Figure:
    """Return the median of repetitions, and the highest."""
    return Figure(what, median(values), unit, target, worst=max(values), beside=beside)


def percentile(values: Sequence[float], percent: float) -> float:
    """Return a percentile of values, which may be infinite: one of them."""
    return float(np.percentile(values, percent, method='higher'))


def machine() -> dict[str, Any]:
    models = [line.partition(':')[2].strip() for line in Path('/proc/cpuinfo').read_text().split(
        '\n') if line.startswith('model name')]
    return {
        'date': datetime.now(UTC).isoformat(timespec='minutes'),
        'processor': models[0] if models else platform.machine(), 'cores': os.cpu_count(),
        'load before': round(os.getloadavg()[0], 1),
        'python': platform.python_version()}


def rows(figures: Sequence[Figure]) -> list[list[str]]:
    """Return a table without its empty columns, its heading first; missed targets are bold."""
    table = [['what', 'value', 'target', 'beside'], *map(cells, figures)]
    used = [any(column[1:]) for column in zip(*table)]
    return [[cell for cell, kept in zip(row, used) if kept] for row in table]


def cells(figure: Figure) -> list[str]:
    """Return what a figure is, its value and target, and what is beside it."""
    unit = f' {figure.unit}' if figure.unit else ''
    worst = '' if figure.worst is None else f' (at worst {number(figure.worst)})'
    target = ''
    if figure.target is not None:
        mark = '**' if figure.missed else ''
        target = f'{mark}<= {number(figure.target)}{mark}'
    return [figure.what, number(figure.value) + unit + worst, target, figure.beside]


def number(value: float) -> str:
    """Return a number to three digits, without an exponent where it is large."""
    return f'{value:,.0f}' if value >= 1000 else f'{value:.3g}'


def load() -> dict[str, Any]:
    """Return the saved results, by program."""
    return json.loads(RESULTS.read_text('utf-8'))


def figures_of(results: dict[str, Any], program: str) -> list[Figure]:
    return [Figure(**each) for each in results[program]['figures']]


def run(program: str, measure: Callable[[], list[Figure]], *, whole: bool = True) -> None:
    """Run a bench program: measure, print the table; save it if it is a whole one."""
    where = machine()
    print(f'{program}: ' + ', '.join(f'{name} {value}' for name, value in where.items()))
    figures = measure()
    print(columns(rows(figures)))
    if whole:
        results = load()
        results[program] = {'where': where, 'figures': [figure._asdict() for figure in figures]}
        RESULTS.write_text(json.dumps(results, indent=1) + '\n', 'utf-8')
