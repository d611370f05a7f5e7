# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Make each fault many times and print a table: `make faults ARGS='[OPTIONS] [FAULT ...]'`.

The exit code is 1 if a try has failed.
"""

import argparse
import json
import os
from pathlib import Path
from random import Random
import sys
from tempfile import TemporaryDirectory

from campaign.cases import FAULTS
from campaign.fault import Fault, Result
from campaign.noise import noise
from campaign.stage import Stage, staged
from campaign.table import as_json, markdown, Row


def attempt(fault: Fault, stage: Stage, random: Random) -> Result:
    """Make a fault once; an error or a timeout is a result as well."""
    wrong = len(stage.watch.wrong)
    try:
        fault.prepare(stage)
        result = fault.try_once(stage, random)
    except (AssertionError, TimeoutError, OSError) as error:
        result = Result(trouble=str(error) or repr(error))
    result.wrong = stage.watch.wrong[wrong:]
    return result


def attempts(fault: Fault, times: int, seed: int) -> Row:
    """Make a fault many times; use new processes after a try that failed."""
    row, done = Row(fault), 0
    while done < times:
        with TemporaryDirectory(prefix='faults-') as folder, staged(Path(folder)) as stage:
            while done < times:
                result = attempt(fault, stage, Random(f'{seed} {fault.name} {done}'))
                row.results.append(result)
                done += 1
                if result.trouble:
                    print(f'{fault.name}: {result.trouble}', file=sys.stderr)
                    if stage.node is not None:
                        print(stage.node.output[-3000:], file=sys.stderr)
                    break
    return row


def noise_report(times: int, seed: int) -> str:
    """Run a noisy line in memory, one minute for each time; return the result as a sentence."""
    runs = [noise(seed + number, 60) for number in range(times)]
    whole, wrong = sum(each.undamaged for each in runs), sum(len(each.wrong) for each in runs)
    kept = min(each.kept for each in runs)
    return (f'\nNoisy line in memory, {times} min: {whole} frames arrived undamaged, at least '
            f'{kept:.1%} of them were published, and {wrong} that the robot never sent.\n')


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog='faults', description=__doc__)
    parser.add_argument('names', nargs='*', metavar='FAULT',
                        help='part of the names of faults to make; default: all')
    parser.add_argument('--times', type=int, default=10, help='tries of each (default: 10)')
    parser.add_argument('--seed', type=int, default=0, help='seed of all random choices')
    parser.add_argument('--json', type=Path, metavar='FILE', help='write every try to a file')
    parser.add_argument('--markdown', type=Path, metavar='FILE', help='write the table to a file')
    options = parser.parse_args()
    faults = [fault for fault in FAULTS if not options.names
              or any(name in fault.name for name in options.names)]
    if not faults:
        parser.error(f'no fault has such a name; there are: {", ".join(f.name for f in FAULTS)}')
    rows = []
    for fault in faults:
        rows.append(attempts(fault, options.times, options.seed))
        print('  '.join(rows[-1].cells()), flush=True)
        for failure in rows[-1].failures:
            print(f'    FAILED: {failure}', flush=True)
    table = markdown(rows) + noise_report(options.times, options.seed)
    print(f'\n{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n\n{table}')
    if options.json:
        options.json.write_text(json.dumps(as_json(rows), indent=1), encoding='utf-8')
    if options.markdown:
        options.markdown.write_text(table, encoding='utf-8')
    tries = sum(len(row.results) for row in rows)
    print(f'{len(rows)} faults, {tries} tries, {sum(len(row.failures) for row in rows)} failed')
    return int(any(row.failures for row in rows))
