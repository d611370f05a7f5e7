# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a capture holds."""

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
    records = []
    try:
        for record in records_of([path.read_bytes()], CaptureReader()):
            records.append(record)
    except CaptureError as error:
        return records, str(error)
    return records, ''


def said(records: list[Record], kind: RecordKind = RecordKind.FROM_ROBOT) -> bytes:
    """Return all bytes of one direction."""
    return b''.join(record.data for record in records if record.kind is kind)
