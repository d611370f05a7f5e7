# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where .venv, build/ and install/ are.

They are in the clone, unless its path has characters that colcon, CMake or the first line of a
script cannot take: a space, an umlaut. Then they are links into the user's cache. This file must
run with any Python 3.
"""

import hashlib
import os
from pathlib import Path
import re
import shutil

LINKED = '.venv', 'build', 'install'
PLAIN = re.compile(r'[A-Za-z0-9_./+@~-]+')


def is_plain(path):
    """Return whether everything can be built in a folder."""
    return PLAIN.fullmatch(str(path)) is not None


def elsewhere():
    """Return the folder outside the clone that the links lead to."""
    cache = os.environ.get('XDG_CACHE_HOME') or os.path.join(os.path.expanduser('~'), '.cache')
    name = hashlib.sha256(os.fsencode(os.getcwd())).hexdigest()[:12]
    return Path(cache) / ('create_oi_ros-' + name)


def make_anew():
    """Remove .venv, build/ and install/; if the clone's path is not plain, link empty ones."""
    target = elsewhere()
    shutil.rmtree(str(target), ignore_errors=True)
    for name in map(Path, LINKED):
        if name.is_symlink():
            name.unlink()
        shutil.rmtree(str(name), ignore_errors=True)
        if not is_plain(os.getcwd()):
            (target / name).mkdir(parents=True)
            name.symlink_to(target / name)
