# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a capture holds."""

from create_oi_ros.oi.tools.capture_format import (
    CaptureError,
    CaptureReader,
    Record,
    RecordKind,
    records_of,
)


def read(data: bytes, size: int = 1 << 20) -> tuple[dict[str, str] | None, list[Record], str]:
    """Return facts, records and what was wrong with the file, read in pieces."""
    reader, records = CaptureReader(), []
    try:
        for record in records_of(
                (data[at:at + size] for at in range(0, len(data), size)), reader):
            records.append(record)
    except CaptureError as error:
        return reader.facts, records, str(error)
    return reader.facts, records, ''


def said(records: list[Record], kind: RecordKind = RecordKind.FROM_ROBOT) -> bytes:
    """Return all bytes of one direction."""
    return b''.join(record.data for record in records if record.kind is kind)
