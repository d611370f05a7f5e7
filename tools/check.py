# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Print in one line what is missing to build the project with this Python on this machine.

Exit code 0: nothing; 1: something that can be installed; 2: another Python is needed.
This file must run with any Python 3, so that an old one gets a message and not a SyntaxError.
"""

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import sysconfig

import folders

OLDEST, NEWEST = (3, 11), (3, 13)
DISK_BYTES = 2e9


def compiles(language, compilers, program):
    """Return whether the first of these compilers that is installed compiles a program."""
    found = [c for c in compilers if c and shutil.which(c.split()[0])][:1]
    return any(subprocess.run(c.split() + ['-x', language, '-', '-o', os.devnull],
                              input=program, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL).returncode == 0 for c in found)


def lacks_compiler():
    """Return whether there is no working C and C++ compiler with the libraries' headers."""
    c = [os.environ.get('CC'), 'cc', 'gcc', 'clang']
    cxx = [os.environ.get('CXX'), 'c++', 'g++', 'clang++']
    return not (compiles('c', c, b'#include <stdio.h>\nint main(void) { return 0; }')
                and compiles('c++', cxx, b'#include <string>\nint main() { return 0; }'))


def lacking_python_part():
    """Return which part of this Python is missing and how to install it; None if none is."""
    major, minor = sys.version_info[:2]
    apt = f'for {sys.executable}: sudo apt-get install python{major}.{minor}-'
    if not all(map(importlib.util.find_spec, ('venv', 'ensurepip'))):
        return 'no venv module ' + apt + 'venv'
    if not os.path.exists(os.path.join(sysconfig.get_path('include'), 'Python.h')):
        return 'no Python headers ' + apt + 'dev'
    return None


def unsuitable(kind):
    """Return why another Python is needed; None if this one will do."""
    major, minor = sys.version_info[:2]
    if not OLDEST <= (major, minor) <= NEWEST:
        return (f'{sys.executable} is Python {major}.{minor}, not 3.11 to 3.13: install one '
                '(sudo apt-get install python3.11 python3.11-venv python3.11-dev) '
                'or name it with make PYTHON=...')
    if kind == 'jazzy' and subprocess.call([sys.executable, '-c', 'import rclpy']):
        return (f'{sys.executable} cannot import the rclpy of the ROS that is sourced: '
                'name one that can with make PYTHON=...')
    return None


def lacking(kind):
    """Return what must be installed or changed on this machine; None if nothing."""
    if kind == 'wheels' and os.environ.get('ROS_DISTRO'):
        return (f'ROS 2 {os.environ["ROS_DISTRO"]} is sourced, and this is for Jazzy: '
                'use a shell without it')
    if kind == 'wheels' and (sys.platform, platform.machine()) != ('linux', 'x86_64'):
        return ('ROS 2 comes as wheels for x86-64 Linux only: '
                'here, install ROS 2 Jazzy and source /opt/ros/jazzy/setup.bash')
    if not os.access('.', os.W_OK):
        return (f'{os.getcwd()} cannot be written by you: clone the repository to a folder of '
                'your own')
    if "'" in os.getcwd() or '\n' in os.getcwd():
        return f'make cannot work in a path with a quote or line end: rename {os.getcwd()!r}'
    if not folders.is_plain(os.getcwd()) and not folders.is_plain(folders.elsewhere()):
        return (f'ROS cannot build in a path with a space or other special characters, neither '
                f'in {os.getcwd()} nor in {folders.elsewhere().parent}: set XDG_CACHE_HOME to a '
                'folder whose path has none')
    if lacks_compiler():
        return 'no working C and C++ compiler: sudo apt-get install build-essential'
    if shutil.disk_usage('.').free < DISK_BYTES:
        return f'less than {DISK_BYTES / 1e9:.0f} GB free on the disk of {os.getcwd()}: free some'
    return lacking_python_part() or lacking_of_ros(kind)


def lacking_of_ros(kind):
    """Return what an installed ROS lacks; None if nothing. The wheels have everything."""
    if kind == 'jazzy' and not shutil.which('colcon'):
        return 'no colcon: sudo apt-get install python3-colcon-common-extensions'
    if kind == 'jazzy' and not importlib.util.find_spec('serial'):
        return 'no pyserial: sudo apt-get install python3-serial'
    return None


def main():
    """Print the first problem and exit with its code."""
    kind = sys.argv[1]
    for find, code in ((unsuitable, 2), (lacking, 1)):
        problem = find(kind)
        if problem:
            print(problem)
            sys.exit(code)


main()
