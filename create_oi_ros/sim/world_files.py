# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Worlds by the name under which they are shipped, or from a file of the user's."""

from pathlib import Path

from .world import parse, shipped, shipped_names, World, WorldError


def read_world(text: str) -> World:
    """Read a world by its name or from a file; WorldError says what is wrong, and what allowed."""
    if text in shipped_names():
        return shipped(text)
    try:
        return parse(Path(text).read_text('utf-8-sig'), text)
    except (FileNotFoundError, IsADirectoryError):
        raise WorldError(
            f'{text!r}; allowed: a file, or one of {", ".join(shipped_names())}') from None
    except UnicodeDecodeError:
        raise WorldError(f'{text!r} is no world file: it is not text') from None
    except OSError as error:
        raise WorldError(f'{text!r}: {error.strerror}') from None
