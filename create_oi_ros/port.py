"""
Bytes to and from the outside: a serial device, or any URL that pyserial knows.

A port that cannot be opened, read or written raises `PortError`, whose text says what a person
can do. RTS and DTR are left as the operating system sets them: on some cables a pulse on RTS
changes the robot's baud rate (manual: Serial Port Settings).
"""

import errno
from glob import glob
import os
from typing import Any

import serial

CANDIDATES = ('/dev/create', '/dev/ttyUSB*', '/dev/ttyACM*', '/dev/serial0')
"""Where a Create usually is."""
READ_AT_MOST = 4096


class PortError(OSError):
    """The port is not there, not ours, or gone."""


class Port:
    """An open line to the robot. Reads wait, writes do not return before the bytes are taken."""

    def __init__(self, url: str, baud: int, *, timeout: float) -> None:
        """Open it, exclusively; `timeout` is how long a read waits, in seconds."""
        self.url = url
        try:
            self._serial: Any = serial.serial_for_url(
                url, baudrate=baud, timeout=timeout, write_timeout=1.0, do_not_open=True)
            if '://' not in url:
                self._serial.exclusive = True
            self._serial.open()
        except (OSError, ValueError) as error:
            raise PortError(_advice(url, error)) from error

    def read(self) -> bytes:
        """Return the bytes that have come, waiting for the first; b'' when none came in time."""
        try:
            first: bytes = self._serial.read(1)
            if not first:
                return b''
            waiting = min(self._serial.in_waiting, READ_AT_MOST)
            return first + bytes(self._serial.read(waiting)) if waiting else first
        except (OSError, TypeError) as error:
            # pyserial raises TypeError where another thread has closed the port.
            raise PortError(f'{self.url}: reading failed ({error}); is the cable in?') from error

    def write(self, encoded: bytes) -> None:
        """Write all bytes."""
        try:
            self._serial.write(encoded)
        except (OSError, TypeError) as error:
            raise PortError(f'{self.url}: writing failed ({error}); is the cable in?') from error

    def flush(self) -> None:
        """Wait until all bytes have left this machine."""
        try:
            self._serial.flush()
        except OSError as error:
            raise PortError(f'{self.url}: writing failed ({error}); is the cable in?') from error

    def close(self) -> None:
        """Close it; closing twice is allowed."""
        self._serial.close()


def _advice(url: str, error: Exception) -> str:
    """Say why a port could not be opened and what to do about it."""
    code = _error_number(error)
    if isinstance(error, ValueError):
        return f'{url}: {error}; give a device such as /dev/ttyUSB0 or a URL such as socket://...'
    if code == errno.ENOENT:
        there = sorted(path for pattern in CANDIDATES for path in glob(pattern))
        found = f'there are {", ".join(there)}' if there else 'no serial port was found at all'
        return f'{url} does not exist; {found}: is the cable in? set the parameter `port`'
    if code in (errno.EACCES, errno.EPERM):
        user = os.environ.get('USER', '$USER')
        return f'{url}: no permission; `sudo usermod -aG dialout {user}`, then log in again'
    if code in (errno.EAGAIN, errno.EBUSY):
        return f'{url} is in use by another program; `fuser -v {url}` names it'
    return f'{url} could not be opened: {error}'


def _error_number(error: BaseException | None) -> int | None:
    """Find the operating system's error number, which pyserial may have wrapped."""
    while error is not None:
        if isinstance(error, OSError) and error.errno is not None:
            return error.errno
        error = error.__cause__ or error.__context__
    return None
