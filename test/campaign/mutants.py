# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Small mistakes in the code, one at a time: `make mutants ARGS='[OPTIONS] [PART ...]'`.

A mutant is the code with one number, comparison, operator or decision changed, by cosmic-ray.
The tests of its file should fail then; a mutant that they let pass has survived. All of this
happens in a copy of the repository. The exit code is 1 if less than 90 % of the mutants of a part
were killed.
"""

import argparse
from collections import Counter
from collections.abc import Iterator
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys
from tempfile import TemporaryDirectory
from time import monotonic
from typing import NamedTuple

from support.tables import markdown_table

ROOT = Path(__file__).parents[2]
COPIED = ('create_oi_ros', 'test', 'docs', 'pyproject.toml')
COSMIC_RAY = ROOT / 'build/mutants/bin'
SLOWER, LEAST_LIMIT = 5.0, 5.0
"""Tests that take this many times longer with a mutant, and seconds more, are ended: the mutant
never ends, and counts as killed."""
LEAST = 0.9
"""Share of the mutants of a part that must be killed."""
PARTS = {
    'link/dead_man': ('link/test_dead_man.py',),
    'link/dead_man_process': ('link/test_dead_man.py',),
    'oi/stream': ('oi/test_stream.py', 'oi/test_stream_limits.py'),
    'oi/steering': ('oi/test_steering.py',),
    'oi/script': ('oi/test_commands.py', 'oi/test_text.py', 'oi/test_stream.py'),
    'oi/script_motion': ('oi/test_script_motion.py',),
    'oi/wire': ('oi/test_commands.py', 'oi/test_packets.py', 'oi/test_text.py'),
    'oi/declaration': ('oi/test_commands.py', 'oi/test_text.py'),
    'oi/commands': ('oi/test_commands.py',),
    'oi/packets': ('oi/test_packets.py', 'oi/test_stream.py'),
    'oi/readings': ('oi/test_packets.py', 'oi/test_stream.py'),
    'oi/codes': ('oi/test_commands.py', 'oi/test_packets.py'),
}
"""Files of the package, and the tests that must find their mutants."""
OTHER_OPERATORS = r'core/ReplaceBinaryOperator_\w+_(Mod|Pow|FloorDiv|RShift|LShift|BitXor|BitAnd)'
"""Of the operators that can replace one, +, -, * and / are enough."""
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
HEAD = ('file', 'mutants', 'killed', '%', 'survived')


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


class Laboratory:
    """A copy of the repository in which mutants live."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        for name in COPIED:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, folder / name,
                                ignore=shutil.ignore_patterns('__pycache__', 'node_modules'))
            else:
                shutil.copy(ROOT / name, folder / name)
        self._environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(
            filter(None, (str(folder / 'test'), os.environ.get('PYTHONPATH'))))}

    def try_all(self, part: str) -> list[Mutant]:
        """Try all mutants of a file; SystemExit: the tests fail without any change."""
        tests, begun = [f'test/{test}' for test in PARTS[part]], monotonic()
        command = [sys.executable, '-m', 'campaign.one_mutant']
        if self._run(*command, '600', *tests):
            raise SystemExit(f'{part}: its tests fail before anything is changed')
        limit = LEAST_LIMIT + SLOWER * (monotonic() - begun)
        config, session = self._folder / 'mutants.toml', self._folder / 'session.sqlite'
        config.write_text(CONFIG.format(
            module=f'create_oi_ros/{part}.py', timeout=3 * limit,
            command=' '.join([*command, f'{limit:.1f}', *tests]),
            excluded=json.dumps([OTHER_OPERATORS, ANNOTATIONS])), encoding='utf-8')
        session.unlink(missing_ok=True)
        for tool, *arguments in (
                ('cosmic-ray', 'init', config, session),
                ('cr-filter-operators', session, config),
                ('cosmic-ray', 'exec', config, session)):
            if self._run(COSMIC_RAY / tool, *arguments):
                raise SystemExit(f'{tool} failed')
        return sorted(self._results(session), key=lambda each: (each.line, each.column))

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


def row(part: str, mutants: list[Mutant]) -> tuple[str, ...]:
    """Return a row of the table."""
    counts = Counter(each.killed for each in mutants)
    return (f'`{part}.py`', str(len(mutants)), str(counts[True]),
            f'{100 * share(mutants):.1f}', str(counts[False]))


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
    options = parser.parse_args()
    chosen = [part for part in PARTS
              if not options.parts or any(name in part for name in options.parts)]
    if not chosen:
        parser.error(f'no file has such a name; there are: {", ".join(PARTS)}')
    results = {}
    with TemporaryDirectory(prefix='mutants-') as folder:
        laboratory = Laboratory(Path(folder))
        for part in chosen:
            results[part] = laboratory.try_all(part)
            print('  '.join(row(part, results[part])), flush=True)
            for each in results[part]:
                if not each.killed:
                    print(f'    {each}', flush=True)
    print('\n' + markdown_table(HEAD, [row(*each) for each in results.items()]))
    everything = [mutant for mutants in results.values() for mutant in mutants]
    print(f'{len(everything)} mutants, {share(everything):.1%} killed')
    if options.json:
        options.json.write_text(json.dumps(
            {part: [each._asdict() for each in mutants] for part, mutants in results.items()},
            indent=1), encoding='utf-8')
    return int(min(map(share, results.values())) < LEAST)
