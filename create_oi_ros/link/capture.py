# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Writes the raw line to a file: all bytes of both directions, as they pass, with their times.

The session adds what passes. A disk may be slow or full, and the line must not wait for it. So
adding only appends to memory, and a thread of the capture's own writes twice a second: no more
than that is lost when the process is killed. While a disk hangs, what does not fit into
PENDING_LIMIT is dropped and counted.
"""

from collections.abc import Callable, Mapping
from datetime import datetime, UTC
import errno
from itertools import count
import os
from pathlib import Path
import threading
import time

from ..oi.tools.capture_format import encode_head, encode_record, RECORD_LIMIT, RecordKind

WRITE_INTERVAL = 0.5
"""Seconds between two writes."""
PENDING_LIMIT = 4_000_000
"""Bytes that wait for the disk at most: some ten minutes of a driving robot."""
CLOSE_TIMEOUT = 2.0
"""Seconds that `close` waits for a slow disk."""


def new_file(wanted: str) -> tuple[int, Path]:
    """
    Open a new file to write to; return its descriptor and its path, or raise OSError.

    A file that exists is kept: a number is added to the name. A driver that is started again, by
    hand or by an init system, must neither overwrite the record of what ended it nor fail.
    """
    path = first = Path(os.path.expanduser(wanted))
    if first.is_dir():
        raise IsADirectoryError(errno.EISDIR, 'is a folder; give a file', str(first))
    for number in count(2):
        try:
            return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644), path
        except FileExistsError:
            path = first.with_stem(f'{first.stem}-{number}')
    raise AssertionError('numbers do not end')


class Capture:
    """A file that grows; a write that fails ends the capture, and nothing else."""

    def __init__(
        self, wanted: str, facts: Mapping[str, object], on_failure: Callable[[str], None],
    ) -> None:
        """
        Start in a new file, whose head holds the facts; OSError where it cannot be written.

        `on_failure` is called, on any thread, with the reason why records are dropped, or why
        nothing more is written.
        """
        self._file, self.path = new_file(wanted)
        self._on_failure = on_failure
        self._dropped = 0
        """Records dropped since the last one that was kept."""
        started = datetime.now(UTC).isoformat(timespec='microseconds')
        self._last = time.monotonic_ns() // 1000
        self._pending = bytearray(encode_head({
            'started': started,
            **{name: ' '.join(str(value).splitlines()) for name, value in facts.items()}}))
        self._over = False
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._write()
        # A disk that hangs must not keep the process from ending.
        self._thread = threading.Thread(target=self._run, name='create_capture', daemon=True)
        self._thread.start()

    def add(self, kind: RecordKind, content: bytes | str = b'') -> None:
        """Add a record of something that happened just now; from any thread."""
        data = content if isinstance(content, bytes) else (
            content.encode('utf-8', 'backslashreplace')[:RECORD_LIMIT])
        with self._lock:
            if self._over:
                return
            self._over = kind is RecordKind.END
            news = ''
            if len(self._pending) > PENDING_LIMIT and not self._over:
                self._dropped += 1
                if self._dropped == 1:
                    news = 'the disk takes no bytes; records are dropped until it does'
            else:
                if self._dropped:
                    news = f'{self._dropped} records were dropped: the disk took no bytes'
                    self._append(RecordKind.NOTE, news.encode())
                    self._dropped = 0
                self._append(kind, data)
        if news:
            self._on_failure(news)

    def _append(self, kind: RecordKind, data: bytes) -> None:
        now = time.monotonic_ns() // 1000
        self._pending += encode_record(now - self._last, kind, data)
        self._last = now

    def close(self) -> None:
        """Write the rest and the end of the file."""
        self.add(RecordKind.END)
        self._closing.set()
        self._thread.join(CLOSE_TIMEOUT)
        if self._thread.is_alive():
            self._on_failure('the disk takes no bytes; the end is not written')

    def _run(self) -> None:
        try:
            while not self._closing.wait(WRITE_INTERVAL):
                self._write()
            self._write()
        except OSError as error:
            with self._lock:
                self._over = True
            self._on_failure(f'{error.strerror}; nothing more is captured, the driver goes on')
        finally:
            os.close(self._file)

    def _write(self) -> None:
        with self._lock:
            unwritten, self._pending = self._pending, bytearray()
        while unwritten:
            del unwritten[:os.write(self._file, unwritten)]
