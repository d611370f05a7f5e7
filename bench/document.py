# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The measured numbers in the documents: `python bench/document.py PAGE.md ...`.

Between `<!-- bench NAME -->` and `<!-- end -->` stands the table of that program in
`results.json`, and where and when it was measured.
"""

from pathlib import Path
import sys
from typing import Any

from create_oi_ros.oi.tools import markdown
from results import figures_of, load, rows

PREFIX = 'bench '
LABEL = PREFIX + r'\w+'


def table(program: str, results: dict[str, Any]) -> str:
    """Return a program's figures in Markdown."""
    where = results[program]['where']
    figures = figures_of(results, program)
    heading, *body = rows(figures)
    missed = any(each.verdict == 'missed' for each in figures)
    return (f'{markdown.table(heading, body)}\n'
            f'`{program}` on {where["date"][:10]}: {where["processor"]}, '
            f'{where["cores"]} cores, load {where["load before"]} before, '
            f'Python {where["python"]}.{" Targets in bold were missed." if missed else ""}\n')


def documented(page: str, results: dict[str, Any]) -> str:
    """Return a page with its tables as they are in the results."""
    return markdown.rewritten(
        page, LABEL, lambda label: table(label.removeprefix(PREFIX), results))


def main() -> None:
    results = load()
    for path in map(Path, sys.argv[1:]):
        path.write_text(documented(path.read_text('utf-8'), results), 'utf-8')


if __name__ == '__main__':
    main()
