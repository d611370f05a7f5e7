# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Small mistakes in the code, one at a time, which the tests should find.

A mutant is the code with one number, comparison, operator or decision changed, by cosmic-ray,
which `make nightly` installs beside .venv. A mutant that the tests of its room let pass has
survived. All of this happens in a copy of the repository, with a sample of each file's mutants.
"""

from contextlib import closing
import json
import os
from pathlib import Path
from random import Random
import shutil
import sqlite3
import subprocess
import sys
from time import monotonic

import pytest

from support.nightly import times
from support.processes import kill_marked, MARK

ROOT = Path(__file__).parents[2]
COPIED = ('create_oi_ros', 'test', 'docs', 'examples', 'pyproject.toml')
COSMIC_RAY = ROOT / 'build/mutants/bin'
SLOWER, LEAST_LIMIT = 5.0, 5.0
"""Tests that take this many times longer with a mutant, and seconds more, are ended: the mutant
never ends, and counts as killed."""
LEAST = 0.9
"""Share of the mutants that must be killed."""
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
ROOMS = 'oi', 'driver', 'driver/goals', 'odometry'
PYTEST = ('-m', 'pytest', '-x', '-q', '-p', 'no:cacheprovider', '-p', 'pytest_timeout',
          '-p', 'pytest_cov.plugin', '-p', 'hypothesispytest', '--hypothesis-profile=unshrunk')


class Laboratory:
    """A copy of the repository in which mutants live."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._limits: dict[str, float] = {}
        for name in COPIED:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, folder / name,
                                ignore=shutil.ignore_patterns('__pycache__'))
            else:
                shutil.copy(ROOT / name, folder / name)
        # Compiled code is kept by second and size of its source: two mutants may share both.
        self._environment = {
            **os.environ, 'PYTHONDONTWRITEBYTECODE': '1', 'PYTHONPATH': os.pathsep.join(filter(
                None, (str(folder), str(folder / 'test'), os.environ.get('PYTHONPATH'))))}

    def survivors(self, file: str, sample: int) -> tuple[int, list[str]]:
        """Try mutants of a file; return how many, and what those have changed that survived."""
        room, _, name = file.rpartition('/')
        top = room.partition('/')[0]
        # Its own tests first: they find most.
        own = sorted((ROOT / 'test' / top).glob(f'test_{name}*.py'))
        tests = [*(f'test/{top}/{path.name}' for path in own), f'test/{top}']
        limit = self._limit(top)
        config, session = self._folder / 'mutants.toml', self._folder / 'session.sqlite'
        self._prepare(limit, tests)
        config.write_text(CONFIG.format(
            module=f'create_oi_ros/{file}.py', timeout=3 * limit,
            command=f'{sys.executable} one_mutant.py',
            excluded=json.dumps([OTHER_OPERATORS, IDENTITY, ANNOTATIONS])), encoding='utf-8')
        session.unlink(missing_ok=True)
        self._run(COSMIC_RAY / 'cosmic-ray', 'init', config, session)
        self._run(COSMIC_RAY / 'cr-filter-operators', session, config)
        source = (self._folder / f'create_oi_ros/{file}.py').read_text(encoding='utf-8')
        drop_bare_stars(session, source.splitlines())
        keep_sample(session, sample, file)
        self._run(COSMIC_RAY / 'cosmic-ray', 'exec', config, session)
        return self._results(session)

    def _limit(self, room: str) -> float:
        """Return the most seconds for a room's tests, which pass while nothing is changed."""
        if room not in self._limits:
            begun = monotonic()
            self._prepare(3600.0, [f'test/{room}'])
            self._run(sys.executable, 'one_mutant.py')
            self._limits[room] = LEAST_LIMIT + SLOWER * (monotonic() - begun)
        return self._limits[room]

    def _prepare(self, limit: float, tests: list[str]) -> None:
        (self._folder / 'one_mutant.py').write_text(
            f'from nightly.test_mutants import killed\nkilled({limit}, {tests})\n')

    def _run(self, *command: str | Path) -> str:
        return subprocess.run([str(word) for word in command], cwd=self._folder, text=True,
                              env=self._environment, check=True, capture_output=True).stdout

    def _results(self, session: Path) -> tuple[int, list[str]]:
        tried, survived = 0, []
        for line in self._run(COSMIC_RAY / 'cosmic-ray', 'dump', session).splitlines():
            job, result = json.loads(line)
            if result is None or result['worker_outcome'] == 'skipped':
                continue
            tried += 1
            if result['test_outcome'] == 'survived':
                survived.append(f"line {job['mutations'][0]['start_pos'][0]}: {result['diff']}")
        return tried, survived


def killed(limit: float, tests: list[str]) -> None:
    """Run the tests of one mutant, in its copy; exit with 0 if it has survived."""
    mark = f'mutant.{os.getpid()}'
    try:
        code = subprocess.run(
            [sys.executable, *PYTEST, *tests], timeout=limit, check=False,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, MARK: mark, 'PYTEST_DISABLE_PLUGIN_AUTOLOAD': '1'}).returncode
    except subprocess.TimeoutExpired:
        code = 1
    finally:
        kill_marked(mark)
    sys.exit(code)


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


def keep_sample(session: Path, sample: int, seed: str) -> None:
    """Remove all but some jobs from cosmic-ray's file: with the same code, the same ones."""
    with closing(sqlite3.connect(session)) as file, file:
        jobs = [job for job, in file.execute(
            'SELECT job_id FROM mutation_specs '
            'WHERE job_id NOT IN (SELECT job_id FROM work_results) '
            'ORDER BY operator_name, operator_args, occurrence')]
        if sample < len(jobs):
            remove(file, Random(seed).sample(jobs, len(jobs) - sample))


@pytest.mark.nightly
@pytest.mark.timeout(5 * 3600)
def test_nine_of_ten_mistakes_are_found(tmp_path):
    laboratory, tried, survived = Laboratory(tmp_path), 0, []
    files = [f'{room}/{path.stem}' for room in ROOMS
             for path in sorted((ROOT / 'create_oi_ros' / room).glob('[!_]*.py'))]
    for file in files[:times(len(files))]:
        count, left = laboratory.survivors(file, 10)
        tried += count
        survived += [f'{file}: {each}' for each in left]
    print(*survived, sep='\n')
    assert len(survived) <= (1 - LEAST) * tried
