# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Files that are written as a whole or not at all."""

from contextlib import suppress
import os
from pathlib import Path
from stat import S_IMODE


def write_whole(target: Path, content: bytes) -> None:
    """
    Write a file beside the target and rename it, so that a full disk leaves the target as it was.

    A device such as /dev/stdout is written directly. OSError: it cannot be; it names the target.
    """
    real = Path(os.path.realpath(target))
    try:
        if real.exists() and not real.is_file():
            real.write_bytes(content)
        else:
            _replace(real, content)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(target)) from error


def _replace(target: Path, content: bytes) -> None:
    beside = target.with_name(f'.{target.name}.{os.getpid()}')
    try:
        beside.write_bytes(content)
        if target.exists():
            beside.chmod(S_IMODE(target.stat().st_mode))
        beside.replace(target)
    except OSError:
        with suppress(FileNotFoundError):  # where it could not be created
            beside.unlink()
        raise
