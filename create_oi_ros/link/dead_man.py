# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A process that stops the wheels when the driver dies.

The Open Interface has no timeout: a robot whose driver is killed drives on for ever. So a second,
small process holds the line open too and waits on a pipe from the driver. A driver that ends
normally writes a goodbye to the pipe. If the pipe closes without it, the driver is dead, however
it died, and this process writes the bytes that stop the robot.

It also writes them when the driver is suspended (Ctrl-Z, SIGSTOP, a debugger), since nobody is in
command then: at once, and again every second, as the driver may run for a moment in between and
be suspended again. It keeps watching.

`DeadMan` is the driver's side; `dead_man_process` is the process.
"""

import os
import signal
import subprocess
import sys

from . import dead_man_process
from .dead_man_process import GOODBYE

END_TIMEOUT = dead_man_process.WRITE_TIMEOUT + 1.0
"""Seconds after which a process that does not end (suspended, or its line hangs) is killed."""
END_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class DeadMan:
    """Watches over one open line until `release` or `trigger`."""

    def __init__(self, line: int, stop_bytes: bytes) -> None:
        """Start the process; `line` is the file descriptor, `stop_bytes` what stops the robot."""
        watched, self._pipe = os.pipe()
        # The process inherits the mask, so the signals that end its parent never reach it.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, END_SIGNALS)
        try:
            # Isolated and without site-packages; in a session of its own, out of Ctrl-C's reach.
            self._process = subprocess.Popen(
                [sys.executable, '-I', '-S', dead_man_process.__file__, str(watched), str(line),
                 stop_bytes.hex(), str(os.getpid())],
                pass_fds=(watched, line), start_new_session=True,
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        except BaseException:
            os.close(self._pipe)
            raise
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            os.close(watched)

    @property
    def ended(self) -> bool:
        """Whether the process has ended, so that nobody watches."""
        return self._process.poll() is not None

    def release(self) -> None:
        """End the process without writing to the robot."""
        try:
            os.write(self._pipe, GOODBYE)
        except BrokenPipeError:
            # It has been killed: there is nothing left to release.
            return
        finally:
            self.trigger()

    def trigger(self) -> None:
        """End the process after it has stopped the robot, if the line still takes bytes."""
        os.close(self._pipe)
        try:
            self._process.wait(END_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
