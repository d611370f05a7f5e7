# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A path that one process at a time may serve.

The kernel keeps the claim, as an abstract Unix socket named after the path, and drops it when the
process ends, however it ends. So a link or socket that a dead process left is replaced, and that
of a live process is not.
"""

import errno
import hashlib
import os
from pathlib import Path
import socket
import struct

PEER = struct.Struct('3i')
"""Linux, unix(7): process, user and group at the other end."""
CALLERS = 64
"""Refused processes that can still ask for the owner's process id."""


class Claim:
    """Holds a path until `release`."""

    def __init__(self, path: Path) -> None:
        """Claim a path; FileExistsError says which live process has it."""
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
