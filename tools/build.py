# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Build the messages and the package with colcon into install/.

Usage, from the repository root: python tools/build.py KIND. See make_venv.py for KIND.
"""

from collections.abc import Callable, Mapping
import os
from pathlib import Path
import re
import shutil
import sys
import time

from step import clock, interruptible, step

VENV = Path('.venv').resolve()
MESSAGES = 'create_oi_msgs'
UNFINISHED = Path('build').resolve() / 'unfinished'
"""A file that is there while a build runs, and after one that was cut short."""


def wheels_environment() -> Mapping[str, str]:
    """Return environment variables with which the ROS in .venv is the only one."""
    return os.environ | {
        'PATH': f'{VENV}/bin:{os.environ["PATH"]}',
        'VIRTUAL_ENV': str(VENV),
        'AMENT_PREFIX_PATH': str(VENV),
        'CMAKE_PREFIX_PATH': str(VENV),
    }


def installed(package: str) -> bool:
    """Return whether the sourced ROS has a package; our own install/ does not count."""
    prefixes = map(Path, os.environ['AMENT_PREFIX_PATH'].split(':'))
    return any((prefix / 'share' / package).is_dir() for prefix in prefixes
               if Path('install').resolve() not in prefix.parents)


def base_paths(kind: str) -> list[str]:
    """Return the folders to build: with our tf2_msgs where ROS lacks it, as the wheels do."""
    lacks_tf2 = kind == 'wheels' or not installed('tf2_msgs')
    return ['.', 'msg_defs', *(['tools/tf2_msgs'] if lacks_tf2 else [])]


def interfaces(folder: Path) -> set[str]:
    """Return the messages, services and actions that are declared in a folder."""
    return {f'{path.parent.name}/{path.stem}' for kind in ('msg', 'srv', 'action')
            for path in folder.glob(f'{kind}/*.{kind}')}


def forget_stale() -> None:
    """
    Remove the built messages if one of their files has been removed, or a build was cut short.

    Else rosidl keeps the code that joins them to Python, and no node could load any message; or
    make takes half a file for a whole one.
    """
    built = Path('install', MESSAGES, 'share', MESSAGES)
    if UNFINISHED.exists() or interfaces(built) - interfaces(Path('msg_defs')):
        for base in ('build', 'install'):
            shutil.rmtree(Path(base, MESSAGES), ignore_errors=True)


def counting(total: int) -> Callable[[str], str]:
    """Return a function that says how many packages are built, and how far the others are."""
    def say(log: str) -> str:
        begun = re.findall(r'^Starting >>> (\S+)', log, re.M)
        done = re.findall(r'^Finished <<< (\S+)', log, re.M)
        parts = [f'{name} {percent(name)}%' for name in begun if name not in done]
        return ', '.join([f'{len(done)} of {total} packages built', *parts])
    return say


def percent(package: str) -> str:
    """Return how far make is with a package that colcon builds now."""
    try:
        text = (Path('log/latest_build') / package / 'stdout.log').read_text(errors='replace')
    except OSError:
        text = ''
    return (re.findall(r'^\[ *(\d+)%\]', text, re.M) or ['0'])[-1]


def main(kind: str) -> None:
    """Run colcon."""
    began = time.monotonic()
    paths = base_paths(kind)
    forget_stale()
    UNFINISHED.parent.mkdir(parents=True, exist_ok=True)
    UNFINISHED.touch()
    print(f'build: {len(paths)} packages with colcon (log/build.log)', flush=True)
    step(['colcon', 'build', '--base-paths', *paths, '--symlink-install',
          '--build-base', Path('build').resolve(), '--install-base', Path('install').resolve(),
          '--cmake-args', '-Wno-dev', '-DBUILD_TESTING=OFF'],
         'build.log', 'the build failed', wheels_environment() if kind == 'wheels' else None,
         progress=counting(len(paths)))
    UNFINISHED.unlink()
    print(f'build: done in {clock(began)}', flush=True)


if __name__ == '__main__':
    with interruptible():
        main(sys.argv[1])
