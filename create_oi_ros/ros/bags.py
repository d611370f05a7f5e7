# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Bags through the library `rosbags`, which reads and writes them without an installed rosbag2.

`rosbags` is imported inside functions: the node never loads it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
import struct
import sys
from typing import TYPE_CHECKING, TypeVar

from ament_index_python.packages import get_package_share_directory, PackageNotFoundError

from .programs import UserError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

Item = TypeVar('Item')


class BagError(UserError):
    """A bag cannot be read or is not of this driver; the message is one sentence."""


class DamageError(Exception):
    """The content of a bag cannot be read; the message is that of the library."""


FAULTS = (
    AssertionError, AttributeError, EOFError, LookupError, MemoryError, OSError, OverflowError,
    RuntimeError, TypeError, ValueError, struct.error)
"""What Python raises when damaged bytes are read."""
LIBRARY_FAULTS = {
    'backports.zstd': 'ZstdError', 'compression.zstd': 'ZstdError', 'sqlite3': 'Error',
    'rosbags.rosbag2': 'ReaderError', 'rosbags.serde': 'SerdeError',
    'rosbags.typesys': 'TypesysError', 'yaml': 'YAMLError'}
"""Exceptions of libraries, by module."""


def faults() -> tuple[type[Exception], ...]:
    """Return the exceptions that a broken file causes in the libraries that are loaded."""
    return (*FAULTS, *(getattr(sys.modules[module], name)
                       for module, name in LIBRARY_FAULTS.items() if module in sys.modules))


@contextmanager
def reading() -> Iterator[None]:
    """Turn what a broken file causes into DamageError."""
    try:
        yield
    except faults() as error:
        raise DamageError(
            ' '.join(str(error).split())[:200] or type(error).__name__) from error


def guarded(items: Iterable[Item]) -> Iterator[Item]:
    """Yield what is read, under `reading`; exceptions of the caller are not changed."""
    with reading():
        yield from items


def definitions() -> Typestore:
    """Return the message definitions of ROS 2 Jazzy and ours, installed or in the repository."""
    from rosbags.typesys import get_types_from_msg, get_typestore, Stores
    store = get_typestore(Stores.ROS2_JAZZY)
    try:
        share = Path(get_package_share_directory('create_oi_msgs'))
    except PackageNotFoundError:
        share = Path(__file__).parents[2] / 'msg_defs'
    for path in sorted(share.glob('msg/*.msg')):
        store.register(get_types_from_msg(path.read_text(), f'create_oi_msgs/msg/{path.stem}'))
    return store
