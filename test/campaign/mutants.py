# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Small mistakes in the code, one at a time: `make mutants ARGS='[OPTIONS] [PART ...]'`.

A mutant is the code with one number, comparison, operator or decision changed, by cosmic-ray.
The tests of its file should fail then; a mutant that they let pass has survived. All of this
happens in a copy of the repository. The exit code is 1 if less than 90 % of the mutants of a part
were killed, or, with --sample, less than 90 % of all that were tried.
"""

import argparse
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
import json
import os
from pathlib import Path
from random import Random
import shutil
import sqlite3
import subprocess
import sys
from tempfile import TemporaryDirectory
from time import monotonic
from typing import NamedTuple

from campaign.mutant_parts import PARTS
from support.tables import markdown_table

ROOT = Path(__file__).parents[2]
COPIED = ('create_oi_ros', 'test', 'docs', 'pyproject.toml')
COSMIC_RAY = ROOT / 'build/mutants/bin'
SLOWER, LEAST_LIMIT = 5.0, 5.0
"""Tests that take this many times longer with a mutant, and seconds more, are ended: the mutant
never ends, and counts as killed."""
LEAST = 0.9
"""Share of the mutants of a part that must be killed."""
OTHER_OPERATORS = r'core/ReplaceBinaryOperator_\w+_(Mod|Pow|FloorDiv|RShift|LShift|BitXor|BitAnd)'
"""Of the operators that can replace one, +, -, * and / are enough."""
IDENTITY = r'core/ReplaceComparisonOperator_Is(_Eq|Not_NotEq)'
"""`is` stands between members of enums, booleans, None and objects that are kept: `==` finds the
same there."""
ANNOTATIONS = r'core/ReplaceBinaryOperator_(BitOr_\w+|\w+_BitOr)'
"""Nearly every | is in a type, such as `int | None`, which no test runs."""
CONFIG = """
[cosmic-ray]
module-path = "{module}"
timeout = {timeout}
excluded-modules = []
test-command = "{command}"
[cosmic-ray.distributor]
name = "local"
[cosmic-ray.filters.operators-filter]
exclude-operators = {excluded}
"""
SEED = 19
"""Draws the sample: with the same code and number, the same mutants."""
HEAD = ('file', 'mutants tried', 'killed', '%', 'survived')


class Mutant(NamedTuple):
    """One change of the code, and whether the tests found it."""

    operator: str
    line: int
    column: int
    killed: bool
    change: str
    """The line that changed, as it is in the mutant."""

    def __str__(self) -> str:
        return f'line {self.line}, column {self.column}, {self.operator}: {self.change}'


class Tried(NamedTuple):
    """The mutants of a file that were tried."""

    mutants: list[Mutant]
    there_are: int
    """How many mutants the file has."""

    def row(self, part: str) -> tuple[str, ...]:
        """Return a row of the table."""
        counts = Counter(each.killed for each in self.mutants)
        return (f'`{part}.py`', f'{len(self.mutants)} of {self.there_are}', str(counts[True]),
                f'{100 * share(self.mutants):.1f}', str(counts[False]))


class Laboratory:
    """A copy of the repository in which mutants live."""

    def __init__(self, folder: Path, sample: int | None, seed: int) -> None:
        """`sample` is the most mutants to try of a file; None: all."""
        self._folder, self._sample, self._seed = folder, sample, seed
        for name in COPIED:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, folder / name,
                                ignore=shutil.ignore_patterns('__pycache__', 'node_modules'))
            else:
                shutil.copy(ROOT / name, folder / name)
        self._environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(
            filter(None, (str(folder / 'test'), os.environ.get('PYTHONPATH'))))}

    def attempt(self, part: str) -> Tried:
        """Try the mutants of a file; SystemExit: the tests fail without any change."""
        tests, begun = [f'test/{test}' for test in PARTS[part]], monotonic()
        command = [sys.executable, '-m', 'campaign.one_mutant']
        if self._run(*command, '600', *tests):
            raise SystemExit(f'{part}: its tests fail before anything is changed')
        limit = LEAST_LIMIT + SLOWER * (monotonic() - begun)
        config, session = self._folder / 'mutants.toml', self._folder / 'session.sqlite'
        config.write_text(CONFIG.format(
            module=f'create_oi_ros/{part}.py', timeout=3 * limit,
            command=' '.join([*command, f'{limit:.1f}', *tests]),
            excluded=json.dumps([OTHER_OPERATORS, IDENTITY, ANNOTATIONS])), encoding='utf-8')
        session.unlink(missing_ok=True)
        self._tool('cosmic-ray', 'init', config, session)
        self._tool('cr-filter-operators', session, config)
        source = (self._folder / f'create_oi_ros/{part}.py').read_text(encoding='utf-8')
        drop_bare_stars(session, source.splitlines())
        there_are = keep_sample(session, self._sample, f'{self._seed} {part}')
        self._tool('cosmic-ray', 'exec', config, session)
        mutants = sorted(self._results(session), key=lambda each: (each.line, each.column))
        return Tried(mutants, there_are)

    def _tool(self, name: str, *arguments: str | Path) -> None:
        if self._run(COSMIC_RAY / name, *arguments):
            raise SystemExit(f'{name} failed')

    def _run(self, *command: str | Path) -> int:
        return subprocess.run(
            [str(word) for word in command], cwd=self._folder, env=self._environment, check=False,
            stdout=subprocess.DEVNULL).returncode

    def _results(self, session: Path) -> Iterator[Mutant]:
        dumped = subprocess.run(
            [str(COSMIC_RAY / 'cosmic-ray'), 'dump', str(session)], cwd=self._folder,
            capture_output=True, text=True, check=True).stdout
        for line in dumped.splitlines():
            job, result = json.loads(line)
            if result is None or result['worker_outcome'] == 'skipped':
                continue
            mutation, = job['mutations']
            added = [each[1:].strip() for each in (result['diff'] or '').splitlines()
                     if each.startswith('+') and not each.startswith('+++')]
            yield Mutant(
                mutation['operator_name'].removeprefix('core/'), *mutation['start_pos'],
                result['test_outcome'] != 'survived', ' '.join(added))


def drop_bare_stars(session: Path, lines: list[str]) -> None:
    """Remove the jobs that take the * before keyword-only parameters for a product."""
    with closing(sqlite3.connect(session)) as file, file:
        places = file.execute('SELECT job_id, start_pos_row, start_pos_col FROM mutation_specs')
        remove(file, [job for job, row, column in places
                      if lines[row - 1][column:].startswith('*,')])


def remove(file: sqlite3.Connection, jobs: list[str]) -> None:
    """Remove jobs, and what came of them."""
    for table in ('mutation_specs', 'work_results', 'work_items'):
        file.executemany(f'DELETE FROM {table} WHERE job_id = ?', [(job,) for job in jobs])


def keep_sample(session: Path, sample: int | None, seed: str) -> int:
    """Remove all but some jobs from cosmic-ray's file; return how many there were."""
    with closing(sqlite3.connect(session)) as file, file:
        jobs = [job for job, in file.execute(
            'SELECT job_id FROM mutation_specs '
            'WHERE job_id NOT IN (SELECT job_id FROM work_results) '
            'ORDER BY operator_name, operator_args, occurrence')]
        if sample is not None and sample < len(jobs):
            remove(file, Random(seed).sample(jobs, len(jobs) - sample))
    return len(jobs)


def at_least_one(text: str) -> int:
    """Read a number of mutants."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f'{text} is no number of mutants; allowed: 1 or more')
    return int(text)


def share(mutants: list[Mutant]) -> float:
    """Return the share of mutants that were killed."""
    return sum(each.killed for each in mutants) / len(mutants) if mutants else 1.0


def main() -> int:
    """Try mutants from the command line."""
    parser = argparse.ArgumentParser(
        prog='mutants', description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('parts', nargs='*', metavar='PART',
                        help=f'part of the names of files; default: all of {", ".join(PARTS)}')
    parser.add_argument('--json', type=Path, metavar='FILE', help='write every mutant to a file')
    parser.add_argument('--sample', type=at_least_one, metavar='N',
                        help='try only N mutants of each file, drawn at random')
    parser.add_argument('--seed', type=int, default=SEED,
                        help='of the sample; default: %(default)s')
    options = parser.parse_args()
    chosen = [part for part in PARTS
              if not options.parts or any(name in part for name in options.parts)]
    if not chosen:
        parser.error(f'no file has such a name; there are: {", ".join(PARTS)}')
    results: dict[str, Tried] = {}
    with TemporaryDirectory(prefix='mutants-') as folder:
        laboratory = Laboratory(Path(folder), options.sample, options.seed)
        for part in chosen:
            results[part] = laboratory.attempt(part)
            print('  '.join(results[part].row(part)), flush=True)
            for each in results[part].mutants:
                if not each.killed:
                    print(f'    {each}', flush=True)
    print('\n' + markdown_table(HEAD, [tried.row(part) for part, tried in results.items()]))
    everything = [mutant for tried in results.values() for mutant in tried.mutants]
    there_are = sum(tried.there_are for tried in results.values())
    print(f'{len(everything)} of {there_are} mutants, {share(everything):.1%} killed')
    if options.json:
        options.json.write_text(json.dumps(
            {part: [each._asdict() for each in tried.mutants] for part, tried in results.items()},
            indent=1), encoding='utf-8')
    if options.sample is not None:
        return int(share(everything) < LEAST)
    return int(min(share(tried.mutants) for tried in results.values()) < LEAST)
