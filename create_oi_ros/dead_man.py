"""
The last hand on the wheels, for when the driver dies.

The Open Interface has no timeout: a robot whose driver is killed drives on for ever. So a second,
tiny process holds the line too. It waits on a pipe from the driver. When the driver ends well it
says goodbye there; when the pipe closes without a word, the driver is dead, however it died, and
this process writes the bytes that stop the robot.

`DeadMan` is the driver's end. Run as a program, this file is the process: the standard library's
smallest corner, started in a few milliseconds, so that it is there before anything moves.
"""

import os
import signal
import subprocess
import sys

GOODBYE = b'\0'
POLITE = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PATIENCE = 2
"""Seconds after which the process gives up on a line that takes no bytes."""


class DeadMan:
    """Watches over one open line until `release`."""

    def __init__(self, line: int, last_words: bytes) -> None:
        """Start the process; `line` is the file descriptor, `last_words` what stops the robot."""
        watched, self._pipe = os.pipe()
        # It inherits the mask: what ends its parent politely never reaches it.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, POLITE)
        try:
            # Isolated and without site-packages; in a session of its own, out of Ctrl-C's reach.
            self._process = subprocess.Popen(
                [sys.executable, '-I', '-S', __file__, str(watched), str(line), last_words.hex()],
                pass_fds=(watched, line), start_new_session=True,
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            os.close(watched)

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    @property
    def ended(self) -> bool:
        """Whether somebody has ended the process, so that nobody watches."""
        return self._process.poll() is not None

    def release(self) -> None:
        """Let the process end without touching the robot."""
        try:
            os.write(self._pipe, GOODBYE)
        except BrokenPipeError:
            # It has been killed: nothing is left to be released.
            return
        finally:
            os.close(self._pipe)
            self._process.wait()


def watch(pipe: int, line: int, last_words: bytes) -> None:
    """Wait for the driver's goodbye or its death; write the last words after its death."""
    if os.read(pipe, 1) == GOODBYE:
        return
    signal.alarm(PATIENCE)
    os.set_blocking(line, True)
    while last_words:
        last_words = last_words[os.write(line, last_words):]


if __name__ == '__main__':
    watch(int(sys.argv[1]), int(sys.argv[2]), bytes.fromhex(sys.argv[3]))
