# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The line on which a host meets the robot: a pseudo terminal, or a TCP port.

Both behave like a serial port. Bytes are lost while no host has the port open, and when the host
does not read them in time. The robot does not notice that a host comes or goes.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import errno
import fcntl
import hashlib
import os
from pathlib import Path
import select
import socket
import struct
import termios
import tty

from ..firmware.uart import DEFAULT_BAUD

READ_SIZE = 4096
"""Bytes that are read at once."""
TERMINALS = '/dev/pts/'
TCGETS2 = 0x802C542A
TERMIOS2 = struct.Struct('4I B 19s I I')
"""Linux's own structure: the portable one has no 14400 baud."""
OUTPUT_SPEED = struct.Struct(f'{TERMIOS2.size - struct.calcsize("I")}x I')
"""Its last number, bits per second."""
PEER = struct.Struct('3i')
"""Linux, unix(7): process, user and group at the other end."""
CALLERS = 64
"""Refused processes that can still ask for the owner's process id."""


class PathLock:
    """
    Holds a path, for one process at a time, until `release`.

    The kernel keeps the claim, as an abstract Unix socket named after the path, and drops it when
    the process ends, however it ends. So a link or socket that a dead process left is replaced,
    and that of a live process is not.
    """

    def __init__(self, path: Path) -> None:
        """Lock a path; FileExistsError says which live process has it."""
        whole = os.path.join(os.path.realpath(path.parent), path.name)
        name = '\0create_sim ' + hashlib.sha256(os.fsencode(whole)).hexdigest()
        self._socket = socket.socket(socket.AF_UNIX)
        try:
            self._socket.bind(name)
        except OSError as error:
            self._socket.close()
            if error.errno != errno.EADDRINUSE:
                raise
            raise FileExistsError(
                errno.EEXIST, f'belongs to a running create_sim{_owner(name)}; end that one, '
                'or use another path', str(path)) from None
        self._socket.listen(CALLERS)

    def release(self) -> None:
        """Leave the path to others."""
        self._socket.close()


def _owner(name: str) -> str:
    """Return the process that has claimed a name, as text; '' if it cannot be found."""
    with socket.socket(socket.AF_UNIX) as caller:
        caller.setblocking(False)
        try:
            caller.connect(name)
        except OSError:
            return ''
        process, _, _ = PEER.unpack(
            caller.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, PEER.size))
    return f' (process {process})' if process else ''


@contextmanager
def naming(given: object) -> Iterator[None]:
    """Have every OSError inside name what the user gave: not nothing, nor a temporary name."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(given)) from None


class PtyLine:
    """A pseudo terminal, with an optional symbolic link that always points to it."""

    def __init__(self, link: Path | None = None) -> None:
        """
        Make the terminal; OSError names `link` if it cannot be made.

        FileExistsError: it is something else, or belongs to a live simulator.
        """
        self._link = link
        self._lock = None if link is None else PathLock(link)
        self._master = -1
        self._slave_name = ''
        self._present = False
        self._settings = bytearray(TERMIOS2.size)
        """Where the system writes them; as bytes, each call would cost twice as much."""
        self.plug()

    @property
    def name(self) -> str:
        """The link, or the terminal if there is no link."""
        return str(self._link or self._slave_name)

    def plug(self) -> None:
        """Make a new terminal and point the link to it."""
        if self._master >= 0:
            return
        self._master, slave = os.openpty()
        tty.setraw(slave)
        settings = termios.tcgetattr(slave)
        settings[4] = settings[5] = getattr(termios, f'B{DEFAULT_BAUD}')
        termios.tcsetattr(slave, termios.TCSANOW, settings)
        self._slave_name = os.ttyname(slave)
        # If we kept it open, the master could not tell whether a host has it open.
        os.close(slave)
        os.set_blocking(self._master, False)
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLIN)
        if self._link is not None:
            with naming(self._link):
                self._point(self._link)

    def _point(self, link: Path) -> None:
        if link.is_symlink():
            target = os.readlink(link)
            if not target.startswith(TERMINALS):
                raise FileExistsError(
                    errno.EEXIST, f'leads to {target}, which is no pseudo terminal, so it is kept')
        elif link.exists():
            raise FileExistsError(errno.EEXIST, 'is no symbolic link, so it is kept')
        beside = link.with_name(f'.{link.name}.{os.getpid()}')
        beside.symlink_to(self._slave_name)
        beside.replace(link)

    def unplug(self) -> None:
        """Close the terminal; a host that has it open gets an error."""
        if self._master < 0:
            return
        link = self._link
        if link is not None and link.is_symlink() and os.readlink(link) == self._slave_name:
            link.unlink()
        os.close(self._master)
        self._master, self._present = -1, False

    def close(self) -> None:
        """Remove the terminal and the link, and leave the link's name to others."""
        self.unplug()
        if self._lock is not None:
            self._lock.release()

    def watched(self) -> list[int]:
        """Return the terminal while a host has it open; without one it is always readable."""
        return [self._master] if self.connected() else []

    def connected(self) -> bool:
        """Return whether a host has the port open."""
        if self._master >= 0 and not self._present:
            events = self._poll.poll(0)
            self._present = not events or bool(events[0][1] & select.POLLIN)
        return self._present

    def read(self) -> bytes:
        """Return the bytes that have arrived, b'' if none; notice when the host has gone."""
        if not self.connected():
            return b''
        try:
            return os.read(self._master, READ_SIZE)
        except BlockingIOError:
            return b''
        except OSError as error:
            if error.errno != errno.EIO:
                raise
        self._present = False
        # Drop what the last host did not read, so that the next one does not get it.
        with suppress(OSError):
            slave = os.open(self._slave_name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                termios.tcflush(slave, termios.TCIFLUSH)
            finally:
                os.close(slave)
        return b''

    def write(self, data: bytes) -> int:
        """
        Write as many bytes as fit now and return their number; the rest is lost.

        Without a host, all bytes are lost and count as written.
        """
        if not data or not self._present:
            return len(data)
        try:
            return os.write(self._master, data)
        except BlockingIOError:
            return 0

    def baud(self) -> int | None:
        """Return the rate that the host has set, bits per second; None: the right one."""
        if self._master < 0:
            return None
        fcntl.ioctl(self._master, TCGETS2, self._settings)
        baud, = OUTPUT_SPEED.unpack(self._settings)
        return int(baud)


class TcpLine:
    """A TCP port for one `socket://` client at a time; a new client replaces the old one."""

    def __init__(self, host: str, port: int) -> None:
        """Listen; OSError if the address is not available. Port 0 finds a free port."""
        self._address = (host, port)
        self._listener: socket.socket | None = None
        self._client: socket.socket | None = None
        self.plug()

    @property
    def name(self) -> str:
        """The address as a pyserial URL."""
        host, port = self._address
        return f'socket://{f"[{host}]" if ":" in host else host}:{port}'

    def plug(self) -> None:
        if self._listener is None:
            family = socket.AF_INET6 if ':' in self._address[0] else socket.AF_INET
            with naming(self.name):
                self._listener = socket.create_server(self._address, family=family, backlog=4)
            self._listener.setblocking(False)
            self._address = self._listener.getsockname()[:2]

    def unplug(self) -> None:
        self._disconnect()
        if self._listener is not None:
            self._listener.close()
            self._listener = None

    close = unplug

    def _disconnect(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def watched(self) -> list[int]:
        return [each.fileno() for each in (self._listener, self._client) if each is not None]

    def read(self) -> bytes:
        """Return the bytes that have arrived, and notice clients that connect or disconnect."""
        self._accept()
        if self._client is None:
            return b''
        try:
            data = self._client.recv(READ_SIZE)
        except BlockingIOError:
            return b''
        except OSError:
            data = b''
        if not data:
            self._disconnect()
        return data

    def _accept(self) -> None:
        if self._listener is None:
            return
        with suppress(BlockingIOError):
            client, _ = self._listener.accept()
            self._disconnect()
            client.setblocking(False)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._client = client

    def write(self, data: bytes) -> int:
        if not data or self._client is None:
            return len(data)
        try:
            return self._client.send(data)
        except BlockingIOError:
            return 0
        except OSError:
            # `read` notices that the client has gone.
            return len(data)

    def connected(self) -> bool:
        return self._client is not None

    def baud(self) -> int | None:
        """Return None: TCP has no baud rate."""
        return None


Line = PtyLine | TcpLine
"""One serial line, seen from the robot's end; nothing that it does blocks."""
