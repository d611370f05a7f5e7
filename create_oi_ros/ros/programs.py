# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The executables: a function each, which imports the program and runs its `main`.

All begin in `_run`, which answers `--version`, and says in a sentence what the user can mend: most
of such errors come from files and from ROS's own arguments. Any other error is a bug of ours, and
keeps its traceback.

Importing rclpy takes most of a second, in which Ctrl-C would print a traceback. Nothing has been
started by then, so the system's default handler for SIGINT replaces Python's.
"""

import errno
from functools import partial
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from io import TextIOWrapper
import os
from pathlib import Path
import re
from shlex import quote
import signal
import sys

from .. import __version__

PACKAGE = __package__.partition('.')[0]
MODULES = {
    'create_check': 'apps.check.create_check',
    'create_lidar': 'apps.lidar',
    'create_node': 'ros.node',
    'create_record': 'apps.record',
    'create_report': 'apps.report.create_report',
    'create_run': 'apps.run',
    'create_sim': 'sim.server.create_sim',
    'create_web': 'apps.web.create_web',
}
"""Module with the `main` of each program."""
PROGRAMS = {name: f'from {__name__} import {name} as run; raise SystemExit(run())'
            for name in MODULES}
"""Python code that runs a program, for `python -c`; the package need not be installed."""
OURS = 'create_oi_msgs'
FOR_BAGS = {'mcap': ((1, 5), (2,)), 'rosbags': ((0, 11), (0, 12))}
"""Libraries without a Debian package: the first version that fits, and the first that may not."""
NEED_BAGS = ('create_record', 'create_report')
"""Programs that read or write bags."""
JAZZY = Path('/opt/ros/jazzy/setup.bash')
MAKE = '`make` in a clone of this repository, then `source env.sh` there'
ROS = re.compile(r'rclpy|\w+_msgs|std_srvs|rcl_interfaces|ament_index_python|builtin_interfaces')
"""Modules that are missing where ROS is."""
WRONG = 2
"""Exit code when something is wrong that the user can mend."""
NO_READER = 128 + signal.SIGPIPE
"""Exit code when nobody reads the output any more, as of a program that SIGPIPE ends."""
INTERRUPTED = 128 + signal.SIGINT
"""Exit code of a program that Ctrl-C has ended, as shells have it."""
HIGHEST_DOMAIN = 232
"""Domains above it have no UDP ports."""
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
ADVICE = {
    errno.ENOENT: 'it does not exist, or its folder does not: look for a typing error',
    errno.ENOTDIR: 'a part of this path is a file: give a folder',
    errno.EISDIR: 'this is a folder: give a file',
    errno.EEXIST: 'it exists already: give another name',
    errno.EACCES: 'you may not write or read here: give a place of your own',
    errno.EPERM: 'you may not write or read here: give a place of your own',
    errno.EROFS: 'nothing can be written here: give another place',
    errno.ENAMETOOLONG: 'the name is too long: give a shorter one',
}
"""What is wrong with a file, and what to do."""
RULE = re.compile(r"Couldn't parse .*?: '(-+\S+) ?(.*?)'\. Error: (.*?)(, at /|$)", re.DOTALL)
"""What ROS says of an argument: the option, its value, the reason."""
ALLOWED = {
    '-p': "write -p NAME:=VALUE; an empty text is -p NAME:=\"''\"",
    '-r': "write -r FROM:=TO; a namespace begins with '/': -r __ns:=/robot1",
    '--log-level': 'allowed: debug, info, warn, error, fatal',
    '--params-file': 'give a file of parameters, such as config/create.yaml',
}
LONG = {'--param': '-p', '--remap': '-r'}
PACKAGES = {'serial': 'pyserial', 'yaml': 'pyyaml'}
"""Names of Python modules at pip, where they have another one."""
PACKAGED = ('aiohttp', 'numpy', 'segno', 'serial', 'yaml')
"""Modules that may be missing, and that Debian and Ubuntu have as a package."""
NO_LOGS = 'ROS has no folder for its log files: set HOME, or ROS_LOG_DIR'


class UserError(Exception):
    """Something that the user can mend; the message says what it is and what to do."""


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
        if program in NEED_BAGS:
            check_bag_libraries()
        code = int(import_module(f'{PACKAGE}.{MODULES[program]}').main())
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # The reader of our output has ended, such as `head`; Python's own end would complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NO_READER
    except (ImportError, OSError, RuntimeError, UserError) as error:
        sentence = explained(error)
        if sentence is None:
            raise
        print(f'{program}: {sentence}', file=sys.stderr)
        return WRONG


def _advice(module: str) -> str | None:
    """Say what to do where a module is missing, as it fits this Python; None: it is ours."""
    if module in PACKAGED:
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


def installing(module: str, *more: str) -> str:
    """Return the command that installs Python modules where this Python finds them."""
    wanted = ' '.join(quote(_requirement(each)) for each in (module, *more))
    if sys.prefix != sys.base_prefix:  # a virtual environment, which apt does not reach
        return f'`{quote(sys.executable)} -m pip install {wanted}`'
    if module in PACKAGED:
        return f'`sudo apt-get install python3-{module}`'
    return f'`python3 -m pip install --break-system-packages {wanted}`'


def _requirement(module: str) -> str:
    """Return what pip calls a module, with the versions that fit."""
    if module not in FOR_BAGS:
        return PACKAGES.get(module, module)
    first, beyond = ('.'.join(map(str, each)) for each in FOR_BAGS[module])
    return f'{module}>={first},<{beyond}'


def check_bag_libraries() -> None:
    """Check that the libraries for bags are there; UserError says which are not, or do not fit."""
    wrong = []
    for module, (first, beyond) in FOR_BAGS.items():
        try:
            found = version(module)
        except PackageNotFoundError:
            wrong.append(f'{module} is missing')
            continue
        if not first <= tuple(map(int, re.findall(r'\d+', found)[:2])) < beyond:
            wrong.append(f'{module} {found} does not fit')
    if wrong:
        raise UserError(f'{", ".join(wrong)}: {installing(*FOR_BAGS)}')


def check_environment() -> None:
    """Check what ROS takes from the environment; UserError says what is wrong."""
    domain = os.environ.get('ROS_DOMAIN_ID', '')
    if domain and not (domain.isdecimal() and int(domain) <= HIGHEST_DOMAIN):
        raise UserError(f'ROS_DOMAIN_ID is {domain!r}: allowed is a whole number from 0 to '
                        f'{HIGHEST_DOMAIN}; `unset ROS_DOMAIN_ID` stands for 0')
    if (os.environ.get('ROS_SECURITY_STRATEGY') == 'Enforce'
            and os.environ.get('ROS_SECURITY_ENABLE') == 'true'
            and not os.environ.get('ROS_SECURITY_KEYSTORE')):
        raise UserError('ROS_SECURITY_STRATEGY is Enforce, but there are no keys: set '
                        'ROS_SECURITY_KEYSTORE, as docs/security.md says')
    folder = log_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f'{folder}: {error.strerror}. {NO_LOGS}') from error
    if not os.access(folder, os.W_OK):
        raise UserError(f'{folder}: Permission denied. {NO_LOGS}')


def log_folder() -> Path:
    """Return the folder in which ROS writes log files; UserError: there is none."""
    for name, inside in (('ROS_LOG_DIR', '.'), ('ROS_HOME', 'log'), ('HOME', '.ros/log')):
        if os.environ.get(name):
            return Path(os.path.expanduser(os.environ[name])) / inside
    raise UserError(NO_LOGS)


def explained(error: Exception) -> str | None:
    """Return a sentence about an error that the user can mend; None: it is a bug."""
    kind, text = type(error).__name__, str(error)  # ROS has no public names for its classes
    match error:
        case UserError():
            return text
        case ModuleNotFoundError():
            return _advice((error.name or '').partition('.')[0])
        case OSError() if error.errno in FULL:
            return f'{_place(error)}{error.strerror}: nothing more can be written'
        case OSError() if error.filename is not None and error.errno in ADVICE:
            return f'{_place(error)}{ADVICE[error.errno]}'
        case RuntimeError() if kind == 'UnknownROSArgsError':
            return (f'unknown among the ROS arguments: {text}; allowed are -p NAME:=VALUE, '
                    '--params-file FILE, -r FROM:=TO, --log-level LEVEL')
        case RuntimeError() if kind == 'RCLInvalidROSArgsError':
            return _rule(text)
        case RuntimeError() if kind == 'RCLError' and text.startswith('failed to initialize'):
            return f'ROS does not start: {text.partition(", at /")[0]}'
    return None


def _place(error: OSError) -> str:
    return '' if error.filename is None else f'{os.fsdecode(error.filename)}: '


def _rule(text: str) -> str:
    """Say in our words which ROS argument is wrong."""
    found = RULE.search(text)
    if found is None:
        return text.partition(', at /')[0]
    option, value, reason, _ = found.groups()
    if option == '--params-file' and not Path(value).is_file():
        return f'--params-file {value}: there is no such file'
    # Of the other options ROS tells only what its parser expected.
    why = f' ({reason.strip()})' if option == '--params-file' else ''
    return f'{option} {value} cannot be read{why}: {ALLOWED[LONG.get(option, option)]}'


create_check = partial(_run, 'create_check')
create_lidar = partial(_run, 'create_lidar')
create_node = partial(_run, 'create_node')
create_record = partial(_run, 'create_record')
create_report = partial(_run, 'create_report')
create_run = partial(_run, 'create_run')
create_sim = partial(_run, 'create_sim')
create_web = partial(_run, 'create_web')
