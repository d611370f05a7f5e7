"""
All bench programs, one after the other: `python bench/everything.py [OPTIONS]`, nine minutes.

Options are handed on. One that fails does not keep the others from being run. The odometry has a
command of its own, since it takes long and needs no quiet machine.
"""

from collections.abc import Sequence
from pathlib import Path
import subprocess
import sys
from time import monotonic

APART = 'bench_odometry'


def programs() -> list[Path]:
    """Return what is run."""
    found = sorted(Path(__file__).parent.glob('bench_*.py'))
    return [path for path in found if path.stem != APART]


def run_all(paths: Sequence[Path], options: Sequence[str]) -> list[str]:
    """Run programs; say how long each took, and which failed."""
    seconds, failed = {}, []
    for path in paths:
        begun = monotonic()
        if subprocess.run([sys.executable, path, *options]).returncode:
            failed.append(path.stem)
        seconds[path.stem] = monotonic() - begun
    each = ', '.join(f'{name} {took:.0f}' for name, took in seconds.items())
    print(f'{sum(seconds.values()):.0f} seconds in all: {each}')
    print(f'These failed, and their older results stand: {", ".join(failed)}.' if failed else
          'All have run, and their results are kept.')
    return failed


if __name__ == '__main__':
    sys.exit(len(run_all(programs(), sys.argv[1:])))
