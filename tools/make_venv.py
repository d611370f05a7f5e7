"""
Make .venv with the versions in pins.txt.

Usage: python tools/make_venv.py KIND. With `wheels`, .venv holds ROS 2 Jazzy and the developer
tools; with `jazzy`, ROS is the system's and .venv adds the tools.
"""

from pathlib import Path
import shutil
import sys
import venv

from step import step

VENV = Path('.venv')
PINS = Path(__file__).with_name('pins.txt')
PIP = (VENV / 'bin/python', '-m', 'pip', '--disable-pip-version-check', '--no-input', 'install',
       '--no-deps', '--progress-bar', 'off')


def read_pins(section: str) -> list[str]:
    """Return the pins between `# [section]` and the next section."""
    text = PINS.read_text().split(f'# [{section}]')[1].split('# [')[0]
    return [line for line in text.splitlines()[1:] if line and not line.startswith('#')]


def install(kind: str, pins: list[str]) -> None:
    """Install one small package without retries, then all: so a missing registry fails fast."""
    # With an installed ROS, .venv gets its own tools even if the system has them, too.
    own = ['--ignore-installed'] if kind == 'jazzy' else []
    step([*PIP, *own, '--retries', '0', '--timeout', '10', pins[0]], 'setup.log',
         'cannot fetch from the Python package registry: check the network, the proxy '
         "and pip's index-url", show=False)
    step([*PIP, *own, *pins], 'setup.log', 'pip failed')


def name_this_python() -> None:
    """Make the wheels' CMake files name this Python, not that of their build machine."""
    step([VENV / 'bin/python', Path(__file__).with_name('patch_cmake.py'), VENV / 'share'],
         'setup.log', 'the CMake files of the wheels could not be adapted')


def main(kind: str) -> None:
    """Remove .venv and what was built with it, and make .venv anew."""
    for old in (VENV, Path('build'), Path('install')):
        shutil.rmtree(old, ignore_errors=True)
    pins = read_pins('tools') + (read_pins('ros') if kind == 'wheels' else [])
    print(f'set-up: Python {sys.version.split()[0]} and {len(pins)} pinned packages into .venv '
          '(about half a minute, log/setup.log)', flush=True)
    venv.create(VENV, with_pip=True, symlinks=True, system_site_packages=kind == 'jazzy')
    install(kind, pins)
    if kind == 'wheels':
        name_this_python()


if __name__ == '__main__':
    main(sys.argv[1])
