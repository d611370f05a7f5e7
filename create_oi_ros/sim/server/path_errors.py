# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What an OSError says: the path or address that the user gave, then what is wrong with it."""

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def naming(given: object) -> Iterator[None]:
    """Have every OSError inside name what the user gave: not nothing, nor a temporary name."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(given)) from None


def sentence(error: OSError) -> str:
    """Return the error as one line."""
    return f'{error.filename}: {error.strerror}' if error.filename else str(error)
