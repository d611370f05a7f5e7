# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The model of a driver's end with more faults than `make test` has time for."""

import argparse

from support.end_model import explore, Rules


def main() -> int:
    """Visit every state; exit code 1 if one is bad."""
    parser = argparse.ArgumentParser(prog='end', description=__doc__)
    parser.add_argument('faults', type=int, nargs='?', default=3, help='in one run, at most')
    found = explore(Rules(), parser.parse_args().faults)
    print(f'{found.states} states visited, {found.ends} of them ends; '
          + (f'bad: {" > ".join(found.bad)}' if found.bad else 'none is bad'))
    return int(found.bad is not None)
