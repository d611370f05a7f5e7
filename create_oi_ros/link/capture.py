"""
The raw line into a file: all bytes of both directions, as they pass, with their times.

`CapturedPort` is a port that tells a `Capture` what passes. A disk may be slow or full; the line
must not wait for it. So whoever tells only appends to memory, and a thread of the capture's own
writes twice a second: that is all that is lost when the process is killed.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from datetime import datetime, UTC
import errno
from itertools import count
import os
from pathlib import Path
import threading
import time
from typing import Any

from .. import __version__
from ..oi.tools.capture_format import encode_head, encode_record, RECORD_LIMIT, RecordKind
from ..ros.parameters import Parameters
from .port import Port, PortError

WRITE_EVERY = 0.5
"""Seconds between two writings."""
LAST_WRITE = 2.0
"""Seconds that the end waits for a slow disk."""
MICROSECOND = 1000
"""In nanoseconds."""


def create(wanted: str) -> tuple[int, Path]:
    """
    Open a new file to write to; return its descriptor and its path. OSError: it cannot be had.

    A file that exists is kept: a number is added to the name. A driver that is started again, by
    hand or by an init system, must neither overwrite what it may have died of nor stay away.
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
    """A file that grows; what cannot be written ends it, and nothing else."""

    def __init__(
        self, file: int, facts: Mapping[str, str], on_failure: Callable[[str], None],
    ) -> None:
        """
        Begin, on an open file; OSError: it takes nothing.

        `on_failure` is told once, on a thread of the capture's own, why nothing more is written.
        """
        self._file = file
        self._on_failure = on_failure
        started = datetime.now(UTC).isoformat(timespec='microseconds')
        self._last = time.monotonic_ns() // MICROSECOND
        self._pending = bytearray(encode_head({'started': started, **facts}))
        self._over = False
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._write()
        # A disk that hangs must not keep the process from ending.
        self._thread = threading.Thread(target=self._run, name='create_capture', daemon=True)
        self._thread.start()

    def add(self, kind: RecordKind, data: bytes = b'') -> None:
        """Note that something has happened just now; from any thread."""
        with self._lock:
            if self._over:
                return
            now = time.monotonic_ns() // MICROSECOND
            self._pending += encode_record(now - self._last, kind, data)
            self._last = now
            self._over = kind is RecordKind.END

    def tell(self, kind: RecordKind, text: str) -> None:
        """Note something in words."""
        self.add(kind, text.encode('utf-8', 'backslashreplace')[:RECORD_LIMIT])

    def close(self) -> None:
        """Write the end."""
        self.add(RecordKind.END)
        self._closing.set()
        self._thread.join(LAST_WRITE)

    def _run(self) -> None:
        try:
            while not self._closing.wait(WRITE_EVERY):
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


def begin(values: Parameters, log: Any) -> Capture | None:
    """Begin what the parameters ask for, and log it; ValueError says why it cannot be had."""
    if not values.capture:
        return None
    facts = {'driver': f'create_oi_ros {__version__}', **asdict(values)}
    try:
        file, path = create(values.capture)
        capture = Capture(
            file, {name: ' '.join(str(value).splitlines()) for name, value in facts.items()},
            lambda why: log.error(f'capture {path}: {why}'))
    except OSError as error:
        raise ValueError(
            f'parameter capture: {values.capture} cannot be written: {error.strerror}') from error
    log.info(f'every byte of the line is written to {path}')
    return capture


class CapturedPort(Port):
    """A port all of whose bytes are captured."""

    def __init__(self, capture: Capture, url: str, baud: int, *, timeout: float) -> None:
        """Open it as `Port` does; the capture lives longer than the port."""
        super().__init__(url, baud, timeout=timeout)
        self._capture = capture
        self._lost = False
        self._captured_baud = baud
        capture.tell(RecordKind.OPENED, f'{url} at {baud} baud')

    def read(self) -> bytes:
        """Read as `Port` does."""
        try:
            received = super().read()
        except PortError as error:
            self._lose(error)
            raise
        if received:
            self._capture.add(RecordKind.FROM_ROBOT, received)
        return received

    def write(self, encoded: bytes) -> None:
        """Write as `Port` does; captured before, so that an answer never comes first."""
        if self.baud != self._captured_baud:
            self._captured_baud = self.baud
            self._capture.tell(RecordKind.BAUD, str(self.baud))
        self._capture.add(RecordKind.TO_ROBOT, encoded)
        try:
            super().write(encoded)
        except PortError as error:
            self._lose(error)
            raise

    def _lose(self, error: PortError) -> None:
        # Reading and writing threads may both find out.
        if not self._lost:
            self._lost = True
            self._capture.tell(RecordKind.LOST, str(error))
