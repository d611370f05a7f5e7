# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
All long tests, one after the other, and one table: `make campaign ARGS='[--short] [PART ...]'`.

It takes a night; `--short` takes about ten minutes and shows whether everything works. What a
part prints is in log/campaign. A part that fails, or takes far longer than it should, does not end
the others; the exit code is 1 then.
"""

import argparse
from collections.abc import Sequence
import os
from pathlib import Path
import subprocess
import sys
from time import monotonic
from typing import NamedTuple

from support.processes import kill_marked
from support.tables import markdown_table

ROOT = Path(__file__).parents[2]
LOGS = ROOT / 'log/campaign'
HEAD = ('part', 'what is tried', 'result', 'minutes', '')
LAST_LINES = 20
"""Of the log of a part that failed."""
MARK = 'CREATE_OI_CAMPAIGN_PART'
"""Environment variable by which all processes of a part are found."""


class Part(NamedTuple):
    """A long test: `python test NAME`."""

    name: str
    tries: str
    options: tuple[str, ...]
    short: tuple[str, ...]
    """Options for a try that takes one to three minutes."""
    most: float
    """Minutes after which it is ended: it hangs."""


PARTS = (
    Part('end', "every order of a driver's end", ('3',), ('2',), 10),
    Part('sequences', 'any sequence of events', ('10',), ('0.5',), 30),
    Part('fuzz', 'damaged frames', ('1000000',), ('20000',), 20),
    Part('faults', 'faults of line, robot and process', ('--times', '10'),
         ('--times', '1', 'cable', 'SIG', 'silence', 'stop'), 180),
    Part('soak', 'load and faults at once', ('30',), ('1',), 60),
    Part('mutants', 'mistakes in the code', ('--sample', '40'), ('oi/steering',), 420),
)


class Tried(NamedTuple):
    """What became of a part."""

    part: Part
    ok: bool
    said: str
    """Its last line."""
    seconds: float

    def row(self) -> tuple[str, ...]:
        """Return a row of the table."""
        return (self.part.name, self.part.tries, self.said, f'{self.seconds / 60:.1f}',
                'ok' if self.ok else 'FAILED')


def attempt(part: Part, options: Sequence[str]) -> Tried:
    """Run a part to its end."""
    log, begun = LOGS / f'{part.name}.log', monotonic()
    print(f'{part.name}: {part.tries} ...', flush=True)
    mark = f'{os.getpid()}.{part.name}'
    with log.open('w', encoding='utf-8') as out:
        try:
            code = subprocess.run(
                [sys.executable, str(ROOT / 'test'), part.name, *options], check=False,
                timeout=60 * part.most, env={**os.environ, MARK: mark},
                stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT).returncode
        except subprocess.TimeoutExpired:
            code = 1
            out.write(f'\nended after {part.most:g} min: it hangs\n')
        finally:
            kill_marked(f'{MARK}={mark}')
    lines = [line for line in log.read_text(encoding='utf-8').splitlines() if line.strip()]
    if code:
        print(*lines[-LAST_LINES:], sep='\n', flush=True)
    return Tried(part, code == 0, lines[-1] if lines else 'nothing printed', monotonic() - begun)


def main() -> int:
    """Run all parts, or some."""
    parser = argparse.ArgumentParser(
        prog='campaign', description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [part.name for part in PARTS]
    parser.add_argument('parts', nargs='*', metavar='PART', help=f'of {", ".join(names)}')
    parser.add_argument('--short', action='store_true', help='only a little of each part')
    options = parser.parse_args()
    unknown = set(options.parts) - set(names)
    if unknown:
        parser.error(f'no part {", ".join(sorted(unknown))}; there are: {", ".join(names)}')
    LOGS.mkdir(parents=True, exist_ok=True)
    tried = []
    try:
        for part in PARTS:
            if not options.parts or part.name in options.parts:
                tried.append(attempt(part, part.short if options.short else part.options))
    except KeyboardInterrupt:
        print('interrupted: the table has what was complete')
    print('\n' + markdown_table(HEAD, [each.row() for each in tried]))
    return int(len(tried) < len(options.parts or PARTS) or not all(each.ok for each in tried))
