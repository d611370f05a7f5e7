# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes a world to a file for Nav2 or Gazebo: `create_sim --export`."""

import errno
from pathlib import Path

from ..world import World
from ..world.floor_plan import map_of, sdf_of
from .path_errors import naming

SUFFIXES = ('.yaml', '.sdf')


def export(world: World, path: Path) -> str:
    """Write a world, and say what was written; OSError names a file that cannot be."""
    if path.suffix == '.sdf':
        _write({path: sdf_of(world).encode()})
        return f'{path}: walls for Gazebo'
    drawn, image = map_of(world), path.with_suffix('.pgm')
    _write({path: drawn.yaml(image.name, world.name).encode(), image: drawn.pgm()})
    return f'{path} and {image}: a map for Nav2, {drawn.width} by {drawn.height} cells'


def _write(files: dict[Path, bytes]) -> None:
    """Write new files; where one exists, none is written."""
    for path in files:
        if path.exists():
            raise FileExistsError(
                errno.EEXIST, 'exists already; remove it, or give another name', str(path))
    for path, content in files.items():
        with naming(path):
            path.write_bytes(content)
