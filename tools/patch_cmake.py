# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Make the CMake files of the ROS wheels name the Python that runs this.

Usage: .venv/bin/python tools/patch_cmake.py .venv/share. The wheels were built in a container, and
their exported targets name that container's headers of Python and NumPy.
"""

from pathlib import Path
import re
import sys
import sysconfig

import numpy

HEADERS = (
    (re.compile(r'/opt/python/[^;"]*/include/python3[.0-9]*'), sysconfig.get_path('include')),
    (re.compile(r'/opt/python/[^;"]*/site-packages/numpy/_core/include'), numpy.get_include()),
)


def adapt(file: Path) -> None:
    """Replace the container's paths in one file."""
    text = before = file.read_text()
    for foreign, ours in HEADERS:
        text = foreign.sub(ours, text)
    if text != before:
        file.write_text(text)


for cmake in Path(sys.argv[1]).rglob('*.cmake'):
    adapt(cmake)
