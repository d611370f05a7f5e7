# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Errors that a user causes and can mend: a sentence each, in place of a traceback.

Most of them come from files and from ROS's own arguments. Any other error is a bug of ours, and
keeps its traceback.
"""

import errno
import os
from pathlib import Path
import re
from shlex import quote
import signal
import sys

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
"""Modules that Debian and Ubuntu have as a package."""
NO_LOGS = 'ROS has no folder for its log files: set HOME, or ROS_LOG_DIR'


class UserError(Exception):
    """Something that the user can mend; the message says what it is and what to do."""


def installing(module: str) -> str:
    """Return the command that installs a Python module where this Python finds it."""
    package = PACKAGES.get(module, module)
    if sys.prefix != sys.base_prefix:  # a virtual environment, which apt does not reach
        return f'`{quote(sys.executable)} -m pip install {package}`'
    if module in PACKAGED:
        return f'`sudo apt-get install python3-{module}`'
    return f'`python3 -m pip install --break-system-packages {package}`'


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
            return Path(os.environ[name]).expanduser() / inside
    raise UserError(NO_LOGS)


def explained(error: Exception) -> str | None:
    """Return a sentence about an error that the user can mend; None: it is a bug."""
    match error:
        case UserError():
            return str(error)
        case OSError() if error.errno in FULL:
            return f'{_place(error)}{error.strerror}: nothing more can be written'
        case OSError() if error.filename is not None and error.errno in ADVICE:
            return f'{_place(error)}{ADVICE[error.errno]}'
        case RuntimeError():
            return _explained_by_ros(error)
    return None


def _place(error: OSError) -> str:
    return '' if error.filename is None else f'{os.fsdecode(error.filename)}: '


def _explained_by_ros(error: RuntimeError) -> str | None:
    match type(error).__name__:  # ROS has no public names for these classes
        case 'UnknownROSArgsError':
            return (f'unknown among the ROS arguments: {error}; allowed are -p NAME:=VALUE, '
                    '--params-file FILE, -r FROM:=TO, --log-level LEVEL')
        case 'RCLInvalidROSArgsError':
            return _rule(str(error))
        case 'RCLError' if str(error).startswith('failed to initialize'):
            return f'ROS does not start: {str(error).partition(", at /")[0]}'
    return None


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
