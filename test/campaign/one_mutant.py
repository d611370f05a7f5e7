# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Run the tests of one mutant: `python -m campaign.one_mutant SECONDS TEST ...`.

The exit code is 0 if the mutant survived. A mutant may never end, and its processes may outlive
the tests: all of them are killed. No output is passed on, since a process that is left over could
hold it open.
"""

import os
import subprocess
import sys

from support.processes import kill_marked, MARK

PYTEST = ('-m', 'pytest', '-x', '-q', '-p', 'no:cacheprovider', '-p', 'campaign.unshrunk')


def main() -> int:
    """Run the tests; a mutant whose tests take too long is found out, too."""
    seconds, *tests = sys.argv[1:]
    mark = f'mutant.{os.getpid()}'
    try:
        return subprocess.run(
            [sys.executable, *PYTEST, *tests], timeout=float(seconds), check=False,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, MARK: mark, 'PYTEST_DISABLE_PLUGIN_AUTOLOAD': '1'}).returncode
    except subprocess.TimeoutExpired:
        return 1
    finally:
        kill_marked(f'{MARK}={mark}')


if __name__ == '__main__':
    sys.exit(main())
