# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The executables: a function each, which imports the program and runs its `main`.

All begin in `_run`, which answers `--version`, and says in a sentence what the user can mend.
Importing rclpy takes most of a second, in which Ctrl-C would print a traceback. Nothing has been
started by then, so the system's default handler for SIGINT replaces Python's.
"""

from importlib import import_module
from importlib.util import find_spec
from io import TextIOWrapper
import os
from pathlib import Path
import re
import signal
import sys
from types import ModuleType

from .. import __version__
from .user_errors import explained, installing, UserError

PACKAGE = __package__.partition('.')[0]
MODULES = {
    'create_calibrate': 'apps.calibrate.create_calibrate',
    'create_check': 'apps.check.create_check',
    'create_demo': 'apps.demo.create_demo',
    'create_fleet': 'apps.fleet',
    'create_node': 'ros.node',
    'create_record': 'apps.record',
    'create_report': 'apps.report.create_report',
    'create_run': 'apps.run.create_run',
    'create_sim': 'sim.server.create_sim',
    'create_web': 'apps.web.create_web',
}
"""Module with the `main` of each program."""
PROGRAMS = {name: f'from {__name__} import {name} as run; raise SystemExit(run())'
            for name in MODULES}
"""Python code that runs a program, for `python -c`; the package need not be installed."""
OURS = 'create_oi_msgs'
NEEDED = ('aiohttp', 'numpy', 'serial', 'yaml')
"""Python modules that may be missing."""
JAZZY = Path('/opt/ros/jazzy/setup.bash')
MAKE = '`make` in a clone of this repository, then `source env.sh` there'
ROS = re.compile(r'rclpy|\w+_msgs|std_srvs|rcl_interfaces|ament_index_python|builtin_interfaces')
"""Modules that are missing where ROS is."""
WRONG = 2
"""Exit code when something is wrong that the user can mend."""
NO_READER = 128 + signal.SIGPIPE
"""Exit code when nobody reads the output any more, as of a program that SIGPIPE ends."""


def _run(program: str) -> int:
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.argv[1:] == ['--version']:
        print(program, __version__)
        return 0
    if sys.stdout is None:  # closed by the shell: >&-
        sys.stdout = open(os.devnull, 'w')
    if isinstance(sys.stdout, TextIOWrapper):  # a path may hold letters that a terminal has not
        sys.stdout.reconfigure(errors='backslashreplace')
    try:
        code = int(_imported(program).main())
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # The reader of our output has ended, such as `head`; Python's own end would complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NO_READER
    except (OSError, RuntimeError, UserError) as error:
        sentence = explained(error)
        if sentence is None:
            raise
        print(f'{program}: {sentence}', file=sys.stderr)
        return WRONG


def _imported(program: str) -> ModuleType:
    try:
        return import_module(f'{PACKAGE}.{MODULES[program]}')
    except ModuleNotFoundError as error:
        advice = _advice((error.name or '').partition('.')[0])
        if advice is None:
            raise
        raise UserError(advice) from None


def _advice(module: str) -> str | None:
    """Say what to do where a module is missing, as it fits this Python; None: it is ours."""
    if module in NEEDED:
        return f'{module} is missing: {installing(module)}'
    if not ROS.fullmatch(module):
        return None
    ros = find_spec('rclpy')
    if ros is None:
        sourcing = f'`source {JAZZY}`' if JAZZY.exists() else MAKE
        return f'ROS 2 Jazzy is missing: {sourcing}'
    if module != OURS:
        return f'{module} is missing: it is a part of ROS 2 Jazzy; is all of it installed?'
    if os.environ.get('CREATE_OI_ENV') or str(ros.origin).startswith(f'{sys.prefix}/lib/python'):
        return f'{OURS} is missing: {MAKE}'
    return (f'{OURS} is missing: it is the package msg_defs of this repository: `colcon build '
            '--base-paths src/create_oi_ros src/create_oi_ros/msg_defs`, then `source '
            'install/setup.bash`')


def create_calibrate() -> int:
    """Compute the parameters of the odometry from measured drives."""
    return _run('create_calibrate')


def create_check() -> int:
    """Find out how a robot drives and counts."""
    return _run('create_check')


def create_demo() -> int:
    """Drive a simulated robot through a tour, and report on it."""
    return _run('create_demo')


def create_fleet() -> int:
    """Run the drivers of several robots in one process."""
    return _run('create_fleet')


def create_node() -> int:
    """Run the driver."""
    return _run('create_node')


def create_record() -> int:
    """Record what a robot does to a bag."""
    return _run('create_record')


def create_report() -> int:
    """Show on one page what a robot did, from a bag."""
    return _run('create_report')


def create_run() -> int:
    """Run a robot, its driver and a status line."""
    return _run('create_run')


def create_sim() -> int:
    """Run a simulated robot."""
    return _run('create_sim')


def create_web() -> int:
    """See a robot, and drive it, in a browser."""
    return _run('create_web')
