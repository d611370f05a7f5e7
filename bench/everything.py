# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Run all bench programs: `python bench/everything.py [OPTIONS]`, 45 minutes.

They run one after the other, and options are passed on to each. If one fails, the others still
run. Those of odometry and goals are not among them: they take long and need no quiet machine, so
each has a `make` target of its own.
"""

from collections.abc import Sequence
from pathlib import Path
import subprocess
import sys
from time import monotonic

APART = ('bench_odometry', 'bench_goals', 'bench_check')


def programs() -> list[Path]:
    """Return the programs to run."""
    found = sorted(Path(__file__).parent.glob('bench_*.py'))
    return [path for path in found if path.stem not in APART]


def run_all(paths: Sequence[Path], options: Sequence[str]) -> list[str]:
    """Run programs; print how long each took; return the names of those that failed."""
    seconds, failed = {}, []
    for path in paths:
        begun = monotonic()
        if subprocess.run([sys.executable, path, *options]).returncode:
            failed.append(path.stem)
        seconds[path.stem] = monotonic() - begun
    each = ', '.join(f'{name} {took:.0f}' for name, took in seconds.items())
    print(f'{sum(seconds.values()):.0f} seconds in total: {each}')
    print(f'Failed, older results kept: {", ".join(failed)}' if failed else
          'All succeeded, new results saved.')
    return failed


if __name__ == '__main__':
    sys.exit(len(run_all(programs(), sys.argv[1:])))
