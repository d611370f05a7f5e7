# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Compare the coverage of each package with its floor: `python tools/coverage_floors.py`.

It reads `.coverage`, and the floors under `[tool.coverage-floors]` in pyproject.toml, which may
only rise. The exit code is 1 if a package is below its floor; what it lacks is printed.
"""

from io import StringIO
from pathlib import Path
import sys
import tomllib

from coverage import Coverage

PROJECT = Path(__file__).parents[1] / 'pyproject.toml'


def main() -> int:
    """Print a line for each package, and the report of those below their floor."""
    coverage, low = Coverage(), 0
    coverage.load()
    floors = tomllib.loads(PROJECT.read_text('utf-8'))['tool']['coverage-floors']
    for folder, floor in floors.items():
        report = StringIO()
        covered = coverage.report(include=f'{folder}/*', file=report)
        if covered < floor:
            print(report.getvalue())
            low = 1
        print(f'{folder:25}{covered:8.2f} % of lines and branches, floor {floor:g}')
    return low


if __name__ == '__main__':
    sys.exit(main())
