"""
Bytes to and from the outside: a serial device, or any URL that pyserial knows.

A port that cannot be opened, read or written raises `PortError`, whose text says what a person
can do. RTS and DTR are left as the operating system sets them: on some cables a pulse on RTS
changes the robot's baud rate (manual: Serial Port Settings).
"""

import errno
from glob import glob
import os
from pathlib import Path
import select
import time
from typing import Any

import serial

CANDIDATES = ('/dev/create', '/dev/ttyUSB*', '/dev/ttyACM*', '/dev/serial0')
"""Where a Create usually is."""
READ_AT_MOST = 4096
SETTLED_AFTER = 1.5
"""Seconds after which a device that was plugged in belongs to whom it will."""
FAST = 115200
"""At this rate the robot needs a pause between bytes (manual: Baud)."""
FAST_PAUSE = 0.0002


class PortError(OSError):
    """The port is not there, not ours, or gone."""

    def __init__(self, advice: str, *, passing: bool = False) -> None:
        """Say what a person can do; `passing`: it may mend itself within a second."""
        super().__init__(advice)
        self.passing = passing


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
            raise PortError(_advice(url, error), passing=_settling(url, error)) from error
        self._timeout = timeout
        self._line = self.descriptor
        if self._line is not None:
            self._serial.timeout = 0  # we wait ourselves: one look for all bytes, not two

    @property
    def baud(self) -> int:
        """Bits per second; can be changed while the port is open."""
        return int(self._serial.baudrate)

    @baud.setter
    def baud(self, baud: int) -> None:
        try:
            self._serial.baudrate = baud
        except (OSError, ValueError) as error:
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
        """Return the bytes that have come, waiting for the first; b'' when none came in time."""
        try:
            if self._line is not None:
                ready, _, _ = select.select([self._line], [], [], self._timeout)
                return self._take(self._line) if ready else b''
            first: bytes = self._serial.read(1)
            if not first:
                return b''
            waiting = min(self._serial.in_waiting, READ_AT_MOST)
            return first + bytes(self._serial.read(waiting)) if waiting else first
        except (OSError, TypeError, ValueError) as error:
            # The last two are raised where another thread has closed the port.
            raise PortError(f'{self.url}: reading failed ({error}); is the cable in?') from error

    def _take(self, line: int) -> bytes:
        """Return the bytes that wait; pyserial would look once more whether there are any."""
        if '://' in self.url:
            return bytes(self._serial.read(READ_AT_MOST))
        if not self._serial.is_open:
            raise OSError('it was closed')
        waiting = os.read(line, READ_AT_MOST)
        if not waiting:
            raise OSError('ready, but with nothing to read: it was unplugged')
        return waiting

    def write(self, encoded: bytes) -> None:
        """Write all bytes."""
        try:
            if self.baud < FAST:
                self._serial.write(encoded)
                return
            for byte in encoded:
                self._serial.write(bytes([byte]))
                time.sleep(FAST_PAUSE)
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


def exists(url: str) -> bool:
    """Tell whether a device is there; of a URL nobody can tell, so it is taken to be."""
    return '://' in url or Path(url).exists()


def lasting_name(device: str, names: str = '/dev/serial/by-id') -> str | None:
    """
    Return the name under which a device is found again when it is plugged in elsewhere.

    A USB adapter that comes back may be ttyUSB1 where it was ttyUSB0; by its id it is the same.
    """
    for link in sorted(glob(f'{names}/*')):
        if Path(link).resolve() == Path(device).resolve():
            return link
    return None


def holder(device: str) -> str | None:
    """Name a process that has a device open, where the kernel lets us see it."""
    target = os.path.realpath(device)
    for link in glob('/proc/[0-9]*/fd/*'):
        process = Path(link).parents[1]
        try:
            if os.readlink(link) == target and process.name != str(os.getpid()):
                return f'{(process / "comm").read_text().strip()} (process {process.name})'
        except OSError:
            # It has ended or closed the file since, or belongs to somebody else.
            continue
    return None


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
        by = holder(url) or 'another program'
        return f'{url} is in use by {by}; end it, or give another port'
    return f'{url} could not be opened: {error}'


def _settling(url: str, error: Exception, now: float | None = None) -> bool:
    """Tell whether a device has just been plugged in, so that its group may not be set yet."""
    if _error_number(error) not in (errno.EACCES, errno.EPERM):
        return False
    try:
        changed = os.stat(url).st_ctime
    except OSError:
        return True
    return 0 <= (time.time() if now is None else now) - changed < SETTLED_AFTER


def _error_number(error: BaseException | None) -> int | None:
    """Find the operating system's error number, which pyserial may have wrapped."""
    while error is not None:
        if isinstance(error, OSError) and error.errno is not None:
            return error.errno
        error = error.__cause__ or error.__context__
    return None
