"""
The line on which a host meets the robot: a pseudo terminal, or a TCP port.

Both behave as a serial port does.  What is said while nobody has the port open is lost, what
nobody reads in time is lost, and the robot never notices that a host has come or gone.
"""

from __future__ import annotations

from contextlib import suppress
import errno
import fcntl
import os
from pathlib import Path
import select
import socket
import struct
import termios
import tty
from typing import Protocol

from ..firmware.uart import DEFAULT_BAUD

AT_ONCE = 4096
"""Bytes."""
TCGETS2 = 0x802C542A
TERMIOS2 = struct.Struct('4I B 19s 2I')
"""Linux's own structure: the portable one cannot tell 14400 baud."""


class Line(Protocol):
    """One serial line, seen from the robot's end."""

    @property
    def name(self) -> str:
        """What a host opens."""

    def watched(self) -> list[int]:
        """Return the descriptors that have news for `read`."""

    def read(self) -> bytes:
        """Return what has arrived; b'' where that is nothing, never waits."""

    def write(self, data: bytes) -> int:
        """
        Say bytes; whatever cannot be taken now is lost, as on a wire.

        Returns how many were taken; where no host is there, all of them.
        """

    def baud(self) -> int | None:
        """Return the rate the host has set, bits per second; None: the right one."""

    def unplug(self) -> None:
        """Let the port vanish, as a cable that is pulled out of the computer."""

    def plug(self) -> None:
        """Let the port appear (again)."""

    def close(self) -> None:
        """Leave nothing behind."""


class PtyLine:
    """A pseudo terminal and, where one is wanted, a symbolic link that always leads to it."""

    def __init__(self, link: Path | None = None) -> None:
        """FileExistsError: something that is no symbolic link is in the link's place."""
        self._link = link
        self._master = -1
        self._slave_name = ''
        self._present = False
        self.plug()

    @property
    def name(self) -> str:
        """The link, or the terminal itself."""
        return str(self._link or self._slave_name)

    def plug(self) -> None:
        """Make a new terminal and lead the link to it."""
        if self._master >= 0:
            return
        self._master, slave = os.openpty()
        tty.setraw(slave)
        settings = termios.tcgetattr(slave)
        settings[4] = settings[5] = getattr(termios, f'B{DEFAULT_BAUD}')
        termios.tcsetattr(slave, termios.TCSANOW, settings)
        self._slave_name = os.ttyname(slave)
        # Held open by us it would never tell whether a host is there.
        os.close(slave)
        os.set_blocking(self._master, False)
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLIN)
        if self._link is not None:
            self._lead(self._link)

    def _lead(self, link: Path) -> None:
        if link.exists() and not link.is_symlink():
            raise FileExistsError(errno.EEXIST, 'is no symbolic link; left alone', str(link))
        beside = link.with_name(f'.{link.name}.{os.getpid()}')
        beside.symlink_to(self._slave_name)
        beside.replace(link)

    def unplug(self) -> None:
        """Close the terminal; who has it open gets an error."""
        if self._master < 0:
            return
        if self._link is not None and self._leads_here(self._link):
            self._link.unlink()
        os.close(self._master)
        self._master, self._present = -1, False

    def _leads_here(self, link: Path) -> bool:
        return link.is_symlink() and os.readlink(link) == self._slave_name

    close = unplug

    def watched(self) -> list[int]:
        """Without a host a terminal would be ready, to say so, all the time."""
        self._look()
        return [self._master] if self._present else []

    def _look(self) -> None:
        if self._master < 0 or self._present:
            return
        events = self._poll.poll(0)
        self._present = not events or bool(events[0][1] & select.POLLIN)

    def read(self) -> bytes:
        """Read; notice when a host has gone."""
        self._look()
        if not self._present:
            return b''
        try:
            return os.read(self._master, AT_ONCE)
        except BlockingIOError:
            return b''
        except OSError as error:
            if error.errno != errno.EIO:
                raise
        self._present = False
        self._discard()
        return b''

    def _discard(self) -> None:
        """Drop what the host that has gone did not read: the next one must not find it."""
        with suppress(OSError):
            slave = os.open(self._slave_name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                termios.tcflush(slave, termios.TCIFLUSH)
            finally:
                os.close(slave)

    def write(self, data: bytes) -> int:
        """Write what fits; lose the rest."""
        if not data or not self._present:
            return len(data)
        try:
            return os.write(self._master, data)
        except BlockingIOError:
            return 0

    def baud(self) -> int | None:
        """Return what the host has set the terminal to."""
        if self._master < 0:
            return None
        settings = TERMIOS2.unpack(fcntl.ioctl(self._master, TCGETS2, bytes(TERMIOS2.size)))
        return int(settings[-1])


class TcpLine:
    """A TCP port for `socket://` clients, one at a time: who comes later takes over."""

    def __init__(self, host: str, port: int) -> None:
        """OSError: the address cannot be had.  Port 0 finds a free one."""
        self._address = (host, port)
        self._listener: socket.socket | None = None
        self._client: socket.socket | None = None
        self.plug()

    @property
    def name(self) -> str:
        """The address as pyserial wants it."""
        host, port = self._address
        return f'socket://{f"[{host}]" if ":" in host else host}:{port}'

    def plug(self) -> None:
        """Listen."""
        if self._listener is None:
            family = socket.AF_INET6 if ':' in self._address[0] else socket.AF_INET
            self._listener = socket.create_server(self._address, family=family, backlog=4)
            self._listener.setblocking(False)
            self._address = self._listener.getsockname()[:2]

    def unplug(self) -> None:
        """Hang up and stop listening."""
        self._hang_up()
        if self._listener is not None:
            self._listener.close()
            self._listener = None

    close = unplug

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def watched(self) -> list[int]:
        """Return the listening socket and the host's."""
        return [each.fileno() for each in (self._listener, self._client) if each is not None]

    def read(self) -> bytes:
        """Read; notice who comes and goes."""
        self._accept()
        if self._client is None:
            return b''
        try:
            data = self._client.recv(AT_ONCE)
        except BlockingIOError:
            return b''
        except OSError:
            data = b''
        if not data:
            self._hang_up()
        return data

    def _accept(self) -> None:
        if self._listener is None:
            return
        with suppress(BlockingIOError):
            client, _ = self._listener.accept()
            self._hang_up()
            client.setblocking(False)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._client = client

    def write(self, data: bytes) -> int:
        """Write what fits; lose the rest."""
        if not data or self._client is None:
            return len(data)
        try:
            return self._client.send(data)
        except BlockingIOError:
            return 0
        except OSError:
            # A host that has gone is noticed when it is read from.
            return len(data)

    def baud(self) -> int | None:
        """TCP has no rate, so it is always the right one."""
        return None
