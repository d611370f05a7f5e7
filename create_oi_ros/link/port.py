# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The open line to the robot: a serial device, or any URL that pyserial knows.

A port that cannot be opened, read or written raises `PortError`, whose text says what the user
can do. RTS and DTR are left as the operating system sets them: on some cables a pulse on RTS
changes the robot's baud rate (manual: Serial Port Settings).
"""

from contextlib import suppress
import errno
from glob import glob
import os
from pathlib import Path
import select
import termios
import time
from typing import Any

import serial

from ..oi.codes import FAST_BAUD, FAST_SPACING
from ..robot import MILLI

CANDIDATES = ('/dev/create', '/dev/ttyUSB*', '/dev/ttyACM*', '/dev/serial0')
"""Where a Create usually is."""
NETWORK = ('socket://', 'rfc2217://')
READ_LIMIT = 4096
WRITE_TIMEOUT = 1.0
"""Seconds after which a line that takes no bytes is lost."""
PERMISSIONS_SETTLED = 1.5
"""Seconds after plugging in when a device's permissions are final."""
FAILURE = Exception
"""What pyserial raises when a port fails. Each kind of URL has an exception of its own for a port
that another thread has closed, for a wrong option, for what it cannot do."""


class PortError(OSError):
    """The port is missing, not permitted, in use, or gone."""

    def __init__(self, advice: str, *, temporary: bool = False) -> None:
        """`advice` says what the user can do; a temporary error may go away within a second."""
        super().__init__(advice)
        self.temporary = temporary


class Port:
    """Reads wait for bytes; writes return when the system has taken all bytes."""

    def __init__(self, url: str, baud: int, *, timeout: float) -> None:
        """Open it, exclusively; `timeout` is how long a read waits, in seconds."""
        self.url = url
        # RFC 2217 is read by a thread of pyserial's, and knows no timeout of writing.
        own_thread = url.lower().startswith('rfc2217://')
        try:
            self._serial: Any = serial.serial_for_url(
                url, baudrate=baud, timeout=timeout, exclusive=True, do_not_open=True,
                write_timeout=None if own_thread else WRITE_TIMEOUT)
            self._serial.open()
        except FAILURE as error:
            raise PortError(_advice(url, error), temporary=_settling(url, error)) from error
        self._line = None if own_thread else self.descriptor
        self._waiting = select.poll()
        self._longest = timeout / MILLI
        """Milliseconds that a read waits."""
        if self._line is not None:
            self._waiting.register(self._line, select.POLLIN)
            self._serial.timeout = 0  # `read` waits itself: one system call instead of two

    @property
    def baud(self) -> int:
        """Bits per second; can be changed while the port is open."""
        return int(self._serial.baudrate)

    @baud.setter
    def baud(self, baud: int) -> None:
        try:
            self._serial.baudrate = baud
        except FAILURE as error:
            raise PortError(f'{self.url}: baud rate {baud} cannot be set ({error})') from error

    @property
    def descriptor(self) -> int | None:
        """The operating system's number of the open line; None where it has none."""
        try:
            line = getattr(self._serial, '_socket', self._serial)
            return int(line.fileno())
        except (AttributeError, OSError):
            return None

    def read(self) -> bytes:
        """Wait for bytes and return them; b'' when none came before the timeout."""
        try:
            if self._line is not None:
                if not self._waiting.poll(self._longest):
                    return b''
                if '://' in self.url:
                    return bytes(self._serial.read(READ_LIMIT))
                if not self._serial.is_open:
                    raise OSError('it was closed')
                if received := os.read(self._line, READ_LIMIT):
                    return received
                raise OSError('ready, but with nothing to read: it was unplugged')
            first: bytes = self._serial.read(1)
            if not first:
                return b''
            waiting = min(self._serial.in_waiting, READ_LIMIT)
            return first + bytes(self._serial.read(waiting)) if waiting else first
        except FAILURE as error:
            raise PortError(f'{self.url}: reading failed ({error}); is the cable in?') from error

    def write(self, encoded: bytes) -> None:
        try:
            if self.baud < FAST_BAUD:
                self._serial.write(encoded)
                return
            for byte in encoded:
                self._serial.write(bytes([byte]))
                time.sleep(FAST_SPACING)
        except FAILURE as error:
            raise PortError(f'{self.url}: writing failed ({error}); is the cable in?') from error

    def flush(self) -> None:
        """Wait until all bytes have left this machine."""
        try:
            self._serial.flush()
        except FAILURE as error:
            raise PortError(f'{self.url}: writing failed ({error}); is the cable in?') from error

    def close(self) -> None:
        """Close the port; closing twice, or after it was lost, is allowed."""
        with suppress(FAILURE):
            self._serial.close()


def lasting_name(device: str, names: str = '/dev/serial/by-id') -> str | None:
    """
    Return the name by which a device is found again after it was plugged in elsewhere.

    A USB adapter that was ttyUSB0 may come back as ttyUSB1; its name by id stays.
    """
    return next((link for link in sorted(glob(f'{names}/*'))
                 if os.path.realpath(link) == os.path.realpath(device)), None)


def holder(device: str) -> str | None:
    """Name a process that has a device open; None where the kernel shows none."""
    target = os.path.realpath(device)
    for link in glob('/proc/[0-9]*/fd/*'):
        process = Path(link).parents[1]
        try:
            if os.readlink(link) == target and process.name != str(os.getpid()):
                return f'{(process / "comm").read_text().strip()} (process {process.name})'
        except (OSError, UnicodeDecodeError):
            # It has ended or closed the file since, or belongs to somebody else.
            continue
    return None


def _advice(url: str, error: Exception) -> str:
    """Say why a port could not be opened and what to do about it."""
    cause = _root(error)
    code = _error_number(error)
    if not isinstance(cause, (OSError, termios.error)):
        return (f'{url}: pyserial cannot open this ({type(cause).__name__}: {cause}); give a '
                'device such as /dev/ttyUSB0 or a URL such as socket://HOST:PORT')
    if url.lower().startswith(NETWORK):
        return (f'{url} could not be opened: {cause}; are host and port right, and does the '
                'server there run?')
    if code == errno.ENOENT and '://' not in url:
        there = sorted(path for pattern in CANDIDATES for path in glob(pattern))
        found = f'there are {", ".join(there)}' if there else 'no serial port was found at all'
        return f'{url} does not exist; {found}: is the cable in? Or give another port'
    if code in (errno.ENOTTY, errno.EISDIR):
        return f'{url} is no serial port; give a device such as /dev/ttyUSB0'
    if code in (errno.EACCES, errno.EPERM):
        user = os.environ.get('USER', '$USER')
        return f'{url}: no permission; `sudo usermod -aG dialout {user}`, then log in again'
    if code in (errno.EAGAIN, errno.EBUSY):
        by = holder(url) or 'another program'
        return f'{url} is in use by {by}; end it, or give another port'
    return f'{url} could not be opened: {cause}'


def _settling(url: str, error: Exception, now: float | None = None) -> bool:
    """Tell whether a device has just been plugged in, so that its group may not be set yet."""
    if _error_number(error) not in (errno.EACCES, errno.EPERM):
        return False
    try:
        changed = os.stat(url).st_ctime
    except OSError:
        return True
    return 0 <= (time.time() if now is None else now) - changed < PERMISSIONS_SETTLED


def _error_number(error: BaseException) -> int | None:
    """Return the operating system's error number, which pyserial may have wrapped."""
    cause = _root(error)
    if isinstance(cause, termios.error):
        return int(cause.args[0])
    return cause.errno if isinstance(cause, OSError) else None


def _root(error: BaseException) -> BaseException:
    """Return the exception that began it all."""
    while (before := error.__cause__ or error.__context__) is not None:
        error = before
    return error
