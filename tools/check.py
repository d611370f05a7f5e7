"""
Say in one line what this Python, or this machine, lacks to build the project.

Exit 0: nothing. Exit 1: something that can be installed. Exit 2: another Python is needed.
Runs under any Python 3, so that an old one is refused in words.
"""

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import sysconfig

OLDEST, NEWEST = (3, 11), (3, 13)
DISK_BYTES = 2e9


def compiles(language, compilers, program):
    """Whether the first of these compilers that is installed builds this program."""
    found = [c for c in compilers if c and shutil.which(c.split()[0])][:1]
    return any(subprocess.run(c.split() + ['-x', language, '-', '-o', os.devnull],
                              input=program, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL).returncode == 0 for c in found)


def lacks_compiler():
    """No working C or C++ compiler, C library headers included."""
    c = [os.environ.get('CC'), 'cc', 'gcc', 'clang']
    cxx = [os.environ.get('CXX'), 'c++', 'g++', 'clang++']
    return not (compiles('c', c, b'#include <stdio.h>\nint main(void) { return 0; }')
                and compiles('c++', cxx, b'#include <string>\nint main() { return 0; }'))


def lacking_python_part():
    """Return what is missing of this Python's own parts, with the way to get it."""
    major, minor = sys.version_info[:2]
    apt = f'for {sys.executable}: sudo apt-get install python{major}.{minor}-'
    if not all(map(importlib.util.find_spec, ('venv', 'ensurepip'))):
        return 'no venv module ' + apt + 'venv'
    if not os.path.exists(os.path.join(sysconfig.get_path('include'), 'Python.h')):
        return 'no Python headers ' + apt + 'dev'
    return None


def unsuitable(kind):
    """Return why another Python is needed, if one is."""
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
    """Return what can be installed or freed, and how, if anything must be."""
    if kind == 'wheels' and os.environ.get('ROS_DISTRO'):
        return (f'ROS 2 {os.environ["ROS_DISTRO"]} is sourced, and this is for Jazzy: '
                'use a shell without it')
    if kind == 'wheels' and (sys.platform, platform.machine()) != ('linux', 'x86_64'):
        return ('ROS 2 comes as wheels for x86-64 Linux only: '
                'here, install ROS 2 Jazzy and source /opt/ros/jazzy/setup.bash')
    if ' ' in os.getcwd():
        return f'colcon cannot build in a path with a space: move the clone out of {os.getcwd()}'
    if lacks_compiler():
        return 'no working C and C++ compiler: sudo apt-get install build-essential'
    if shutil.disk_usage('.').free < DISK_BYTES:
        return f'less than {DISK_BYTES / 1e9:.0f} GB free on the disk of {os.getcwd()}: free some'
    return lacking_python_part() or lacking_of_ros(kind)


def lacking_of_ros(kind):
    """Return what an installed ROS lacks; wheels bring all of it."""
    if kind == 'jazzy' and not shutil.which('colcon'):
        return 'no colcon: sudo apt-get install python3-colcon-common-extensions'
    if kind == 'jazzy' and not importlib.util.find_spec('serial'):
        return 'no pyserial: sudo apt-get install python3-serial'
    return None


def main():
    """Print the first complaint and exit by its kind."""
    kind = sys.argv[1]
    for find, code in ((unsuitable, 2), (lacking, 1)):
        complaint = find(kind)
        if complaint:
            print(complaint)
            sys.exit(code)


main()
