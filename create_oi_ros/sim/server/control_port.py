"""The Unix socket on which `Interpreter` is spoken with."""

from __future__ import annotations

from contextlib import suppress
import errno
import os
from pathlib import Path
import socket
import stat

from .control import Interpreter, Waiting

LONGEST_LINE = 4096
"""Bytes; who sends more without an end of line is hung up on."""


class _Visitor:
    """One who is connected: what was said and not yet answered, in order."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.heard = b''
        self.waiting: Waiting | None = None
        self.gone = False


class ControlPort:
    """Serves any number of visitors; whoever waits holds up only himself."""

    def __init__(self, path: Path, control: Interpreter) -> None:
        """Listen; OSError: the path cannot be had, or is no socket."""
        self._path, self._control = path, control
        if path.exists() or path.is_symlink():
            if not stat.S_ISSOCK(os.lstat(path).st_mode):
                raise FileExistsError(errno.EEXIST, 'is no socket; left alone', str(path))
            path.unlink()
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listener.bind(str(path))
        self._listener.listen()
        self._listener.setblocking(False)
        self._inode = os.stat(path).st_ino
        self._visitors: list[_Visitor] = []

    def watched(self) -> list[int]:
        """Return the descriptors that have news for `serve`."""
        return [self._listener.fileno(), *(each.connection.fileno() for each in self._visitors)]

    def serve(self, time: float) -> None:
        """Hear and answer everybody; `time` is the robot's clock, in seconds."""
        with suppress(BlockingIOError):
            connection, _ = self._listener.accept()
            connection.setblocking(False)
            self._visitors.append(_Visitor(connection))
        for visitor in self._visitors:
            self._hear(visitor)
            self._answer(visitor, time)
        for visitor in self._visitors:
            if visitor.gone:
                visitor.connection.close()
        self._visitors = [each for each in self._visitors if not each.gone]

    @property
    def waited_on(self) -> bool:
        """Whether somebody waits for something to happen."""
        return any(each.waiting is not None for each in self._visitors)

    def _hear(self, visitor: _Visitor) -> None:
        try:
            data = visitor.connection.recv(LONGEST_LINE)
        except BlockingIOError:
            return
        except OSError:
            data = b''
        visitor.heard += data
        visitor.gone = not data or len(visitor.heard) > 2 * LONGEST_LINE

    def _answer(self, visitor: _Visitor, time: float) -> None:
        while not visitor.gone:
            if visitor.waiting is not None:
                answer = visitor.waiting.answer(time)
                if answer is None:
                    return
                visitor.waiting = None
                self._say(visitor, answer)
                continue
            line, end, rest = visitor.heard.partition(b'\n')
            if not end:
                return
            visitor.heard = rest
            result = self._control.obey(line.decode('utf-8', 'replace'), time)
            if isinstance(result, Waiting):
                visitor.waiting = result
            else:
                self._say(visitor, result)

    def _say(self, visitor: _Visitor, text: str) -> None:
        try:
            visitor.connection.sendall(text.encode() + b'\n')
        except OSError:
            visitor.gone = True

    def close(self) -> None:
        """Hang up and leave nothing behind."""
        for visitor in self._visitors:
            visitor.connection.close()
        self._listener.close()
        with suppress(OSError):
            if os.stat(self._path).st_ino == self._inode:
                self._path.unlink()
