# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Run a long test by name: `python test NAME [OPTIONS]`, as `make NAME` does.

Python puts this folder on its path, so `campaign` and `support` are found from any directory.
"""

from importlib import import_module
import sys

NAMES = ('faults', 'soak', 'fuzz', 'sequences', 'end', 'mutants', 'campaign')


def main() -> int:
    """Run the module of `campaign` that the first argument names; the rest is for that module."""
    if len(sys.argv) < 2 or sys.argv[1] not in NAMES:
        print(f'usage: python test {{{",".join(NAMES)}}} [OPTIONS]', file=sys.stderr)
        return 2
    return int(import_module(f'campaign.{sys.argv.pop(1)}').main())


if __name__ == '__main__':
    sys.exit(main())
