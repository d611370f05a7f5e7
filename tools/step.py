"""Runs one step of set-up or build; only if it fails, prints the end of its log."""

from collections.abc import Mapping, Sequence
from pathlib import Path
import subprocess
import sys

LAST_LINES = 30


def step(command: Sequence[str | Path], log: str, failure: str,
         env: Mapping[str, str] | None = None, *, show: bool = True) -> None:
    """
    Run a command with its output in a file in log/; if it fails, exit with a message.

    `show=False` leaves out the end of the log, where the message says everything.
    """
    path = Path('log') / log
    path.parent.mkdir(exist_ok=True)
    with path.open('ab') as out:
        start = out.tell()
        code = subprocess.run(command, stdout=out, stderr=out, env=env).returncode
    if code and show:
        lines = path.read_bytes()[start:].decode(errors='replace').splitlines()
        print(*lines[-LAST_LINES:], sep='\n', file=sys.stderr)
    if code:
        sys.exit(f'make: {failure} (complete log: {path})')
