"""
Build the messages and the package with colcon into install/.

Usage, from the repository root: python tools/build.py KIND. See make_venv.py for KIND.
"""

from collections.abc import Mapping
import os
from pathlib import Path
import sys

from step import step

VENV = Path('.venv').resolve()


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


def main(kind: str) -> None:
    """Run colcon."""
    paths = base_paths(kind)
    print(f'build: {len(paths)} packages with colcon (log/build.log)', flush=True)
    step(['colcon', 'build', '--base-paths', *paths, '--symlink-install',
          '--cmake-args', '-Wno-dev', '-DBUILD_TESTING=OFF'],
         'build.log', 'the build failed', wheels_environment() if kind == 'wheels' else None)


if __name__ == '__main__':
    main(sys.argv[1])
