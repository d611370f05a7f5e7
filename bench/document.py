# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The measured numbers in the documents: `python bench/document.py PAGE.md ...`.

Between `<!-- bench NAME -->` and `<!-- end -->` stands the table of that program in
`results.json`, and where and when it was measured.
"""

from collections.abc import Sequence
from pathlib import Path
import re
import sys
from typing import Any

from create_oi_ros.oi.tools import markdown
from results import Figure, figures_of, load, rows

PREFIX = 'bench '
LABEL = PREFIX + r'\w+'
SHOWN = {'bench_odometry': re.compile(
    'deg a turn|(centre|ranges|sign|unsteady): % of the path$|NEES,|at some moment|worse than|'
    'first half minute|damaged line|logs of|an update')}
"""Which figures of a long table its page shows, in its short form; `results.json` has all."""
PART = re.compile('[,:] (95th percentile|at least|at most|mean|slowest|truncate|round|carry)$')
"""Ends of the names of figures that share a row there."""
RIVALS = 'before', 'a reading a second'
"""Names beside figures that get columns of their own there."""


def table(program: str, results: dict[str, Any]) -> str:
    """Return a program's figures in Markdown."""
    where = results[program]['where']
    figures = figures_of(results, program)
    shown = SHOWN.get(program)
    heading, *body = short(figures, shown) if shown else rows(figures)
    return (f'{markdown.table(heading, body)}\n'
            f'`{program}` on {where["date"][:10]}: {where["processor"]}, '
            f'{where["cores"]} cores, load {where["load before"]} before, '
            f'Python {where["python"]}.\n')


def short(figures: Sequence[Figure], shown: re.Pattern[str]) -> list[list[str]]:
    """Return a table of some figures, its heading first; targets that were missed are bold."""
    things: dict[str, dict[str, Figure]] = {}
    for figure in figures:
        if shown.search(figure.what):
            what = re.sub('(, [a-z]+)(: (?:off|% of the way).*)', r'\2\1', figure.what)
            thing, *part = PART.split(what)
            things.setdefault(thing, {})[part[0] if part else ''] = figure
    table = [['what', 'value', 'target', *RIVALS]]
    for thing, parts in things.items():
        what = thing if {'', 'at least'} & parts.keys() else f'{thing}: {", ".join(parts)}'
        columns = zip(*map(cells, parts.values()))
        table.append([what, *(each[0] if len(set(each)) == 1 else ', '.join(filter(None, each))
                              for each in columns)])
    return table


def cells(figure: Figure) -> list[str]:
    """Return value, target and rivals of a figure."""
    unit = f' {figure.unit}' if figure.unit in ('%', 'deg', 'us') else ''
    worst = '' if figure.worst is None else f' (at worst {number(figure.worst)})'
    target = ''
    if figure.target is not None:
        mark = '**' if figure.verdict == 'missed' else ''
        target = f'{mark}{">=" if figure.at_least else "<="} {number(figure.target)}{mark}'
    rivals = dict(re.findall(r'(\D+) ([^ ;]+)(?:; |$)', figure.beside))
    return [number(figure.value) + unit + worst, target,
            *(rivals.get(each, '') for each in RIVALS)]


def number(value: float) -> str:
    """Return a number to three digits, without an exponent where it is large."""
    return f'{value:,.0f}' if value >= 1000 else f'{value:.3g}'


def documented(page: str, results: dict[str, Any]) -> str:
    """Return a page with its tables as they are in the results."""
    return markdown.rewritten(
        page, LABEL, lambda label: table(label.removeprefix(PREFIX), results))


def main() -> None:
    """Write the pages."""
    results = load()
    for path in map(Path, sys.argv[1:]):
        path.write_text(documented(path.read_text('utf-8'), results), 'utf-8')


if __name__ == '__main__':
    main()
