# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a capture holds."""

from collections.abc import Iterable
from pathlib import Path

from create_oi_ros.oi.tools.capture_format import (
    CaptureError,
    CaptureReader,
    Record,
    RecordKind,
    records_of,
)


def read(path: Path) -> tuple[list[Record], str]:
    """Return the records of a file, and the error if there is one."""
    _, records, wrong = read_pieces([path.read_bytes()])
    return records, wrong


def read_pieces(pieces: Iterable[bytes]) -> tuple[dict[str, str] | None, list[Record], str]:
    """Return the facts and records in pieces of a file, and the error if there is one."""
    reader, records = CaptureReader(), []
    try:
        for record in records_of(pieces, reader):
            records.append(record)
    except CaptureError as error:
        return reader.facts, records, str(error)
    return reader.facts, records, ''


def said(records: list[Record], kind: RecordKind = RecordKind.FROM_ROBOT) -> bytes:
    """Return all bytes of one direction."""
    return b''.join(record.data for record in records if record.kind is kind)
