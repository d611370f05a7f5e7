# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The control socket: a Unix socket whose lines go to the `Interpreter`."""

from contextlib import suppress
import errno
import os
from pathlib import Path
import socket
import stat

from .claim import Claim
from .control import Interpreter, Waiting
from .path_errors import naming

LONGEST_LINE = 4096
"""Bytes; a client that sends more without an end of line is disconnected."""


class ControlConnection:
    """One client: its bytes that are not yet obeyed, and the wait it is blocked on."""

    def __init__(self, connection: socket.socket) -> None:
        self.socket = connection
        self.received = b''
        self.waiting: Waiting | None = None
        self.gone = False


class ControlPort:
    """Serves any number of clients; a client that waits does not block the others."""

    def __init__(self, path: Path, control: Interpreter) -> None:
        """
        Listen; OSError names the path if that cannot be.

        FileExistsError: it is no socket, or belongs to a live simulator.
        """
        self._path, self._control = path, control
        with naming(path):
            exists = path.exists() or path.is_symlink()
            if exists and not stat.S_ISSOCK(os.lstat(path).st_mode):
                raise FileExistsError(errno.EEXIST, 'is no socket, so it is kept')
            self._claim = Claim(path)
            path.unlink(missing_ok=True)
            self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            self._listener.bind(str(path))
            self._listener.listen()
        self._listener.setblocking(False)
        self._inode = os.stat(path).st_ino
        self._clients: list[ControlConnection] = []

    def watched(self) -> list[int]:
        """Return the descriptors that become readable when `serve` has something to do."""
        return [self._listener.fileno(), *(each.socket.fileno() for each in self._clients)]

    def serve(self, time: float) -> None:
        """Read and answer all clients; `time` is the robot's clock, in seconds."""
        with suppress(BlockingIOError):
            connection, _ = self._listener.accept()
            connection.setblocking(False)
            self._clients.append(ControlConnection(connection))
        for client in self._clients:
            self._read(client)
            self._answer(client, time)
        for client in self._clients:
            if client.gone:
                client.socket.close()
        self._clients = [each for each in self._clients if not each.gone]

    @property
    def waited_on(self) -> bool:
        """Whether a client waits for something to happen."""
        return any(each.waiting is not None for each in self._clients)

    def _read(self, client: ControlConnection) -> None:
        try:
            data = client.socket.recv(LONGEST_LINE)
        except BlockingIOError:
            return
        except OSError:
            data = b''
        client.received += data
        client.gone = not data or len(client.received) > 2 * LONGEST_LINE

    def _answer(self, client: ControlConnection, time: float) -> None:
        while not client.gone:
            if client.waiting is not None:
                answer = client.waiting.answer(time)
                if answer is None:
                    return
                client.waiting = None
                self._send(client, answer)
                continue
            line, end, rest = client.received.partition(b'\n')
            if not end:
                return
            client.received = rest
            result = self._control.obey(line.decode('utf-8', 'replace'), time)
            if isinstance(result, Waiting):
                client.waiting = result
            else:
                self._send(client, result)

    def _send(self, client: ControlConnection, text: str) -> None:
        try:
            client.socket.sendall(text.encode() + b'\n')
        except OSError:
            client.gone = True

    def close(self) -> None:
        """Disconnect all clients and remove the socket."""
        for client in self._clients:
            client.socket.close()
        self._listener.close()
        with suppress(OSError):
            if os.stat(self._path).st_ino == self._inode:
                self._path.unlink()
        self._claim.release()
