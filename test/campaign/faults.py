"""
The fault campaign as a command: a table, and exit code 1 when a try has failed.

    python -m faults [--times 10] [--seed 0] [--json FILE] [--markdown FILE] [FAULT ...]
"""

import argparse
import json
import os
from pathlib import Path
from random import Random
import sys
from tempfile import TemporaryDirectory

from campaign.cases import Fault, FAULTS, Outcome
from campaign.noise import noise
from campaign.stage import Stage, staged
from campaign.table import as_json, markdown, Row


def attempt(fault: Fault, stage: Stage, chance: Random) -> Outcome:
    """Make a fault once; whatever does not happen is a failure, not the end."""
    wrong = len(stage.watch.wrong)
    try:
        fault.prepare(stage)
        outcome = fault.try_once(stage, chance)
    except (AssertionError, TimeoutError, OSError) as error:
        outcome = Outcome(trouble=str(error) or repr(error))
    outcome.wrong = stage.watch.wrong[wrong:]
    return outcome


def campaign(fault: Fault, times: int, seed: int) -> Row:
    """Make a fault many times, on a fresh stage after one that failed."""
    row, done = Row(fault), 0
    while done < times:
        with TemporaryDirectory(prefix='faults-') as folder, staged(Path(folder)) as stage:
            while done < times:
                outcome = attempt(fault, stage, Random(f'{seed} {fault.name} {done}'))
                row.outcomes.append(outcome)
                done += 1
                if outcome.trouble:
                    print(f'{fault.name}: {outcome.trouble}', file=sys.stderr)
                    if stage.node is not None:
                        print(stage.node.output[-3000:], file=sys.stderr)
                    break
    return row


def in_memory(times: int, seed: int) -> str:
    """Say what a bad line does to frames, a minute for each time."""
    heard = [noise(seed + number, 60) for number in range(times)]
    whole, wrong = sum(each.undamaged for each in heard), sum(len(each.wrong) for each in heard)
    kept = min(each.kept for each in heard)
    return (f'\nA bad line in memory, {times} min: {whole} frames came through whole, at least '
            f'{kept:.1%} of them were published, and {wrong} that the robot never sent.\n')


def main() -> int:
    """Run the campaign."""
    parser = argparse.ArgumentParser(prog='faults', description=__doc__)
    parser.add_argument('names', nargs='*', help='parts of names of faults; default: all')
    parser.add_argument('--times', type=int, default=10, help='tries of each')
    parser.add_argument('--seed', type=int, default=0, help='of all chance')
    parser.add_argument('--json', type=Path, metavar='FILE', help='every try')
    parser.add_argument('--markdown', type=Path, metavar='FILE', help='the table')
    options = parser.parse_args()
    rows = []
    for fault in FAULTS:
        if not options.names or any(name in fault.name for name in options.names):
            rows.append(campaign(fault, options.times, options.seed))
            print('  '.join(rows[-1].cells()), flush=True)
            for failure in rows[-1].failures:
                print(f'    FAILED: {failure}', flush=True)
    table = markdown(rows) + in_memory(options.times, options.seed)
    print(f'\n{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n\n{table}')
    if options.json:
        options.json.write_text(json.dumps(as_json(rows), indent=1), encoding='utf-8')
    if options.markdown:
        options.markdown.write_text(table, encoding='utf-8')
    return int(any(row.failures for row in rows))


if __name__ == '__main__':
    sys.exit(main())
