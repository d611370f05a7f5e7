"""
The last hand on the wheels, for when the driver dies.

The Open Interface has no timeout: a robot whose driver is killed drives on for ever. So a second,
tiny process holds the line too. It waits on a pipe from the driver. When the driver ends well it
says goodbye there; when the pipe closes without a word, the driver is dead, however it died, and
this process writes the bytes that stop the robot.

It does so as well when the driver is stopped and not dead (Ctrl-Z, SIGSTOP, a debugger): then
nobody is in command either. Once for each time, and it goes on watching.

`DeadMan` is the driver's end. Run as a program, this file is the process: the standard library's
smallest corner, started in a few milliseconds, so that it is there before anything moves.
"""

import os
import select
import signal
import subprocess
import sys

GOODBYE = b'\0'
POLITE = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PATIENCE = 2
"""Seconds after which the process gives up on a line that takes no bytes."""
LOOK_EVERY = 0.04
"""Seconds between two looks at whether the driver is stopped; two in a row must see it."""
STOPPED = (b'T', b't')
"""By a signal, and by a debugger (proc(5))."""
STATUS_AT_MOST = 4096


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
                [sys.executable, '-I', '-S', __file__, str(watched), str(line), last_words.hex(),
                 str(os.getpid())],
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


def status_of(process: int) -> int | None:
    """Open what the kernel says of a process; None for one that is gone or hidden."""
    try:
        return os.open(f'/proc/{process}/stat', os.O_RDONLY)
    except OSError:
        return None


def is_stopped(status: int | None) -> bool:
    """Tell whether a process is stopped; one that is gone or hidden is not."""
    try:
        # The name, in brackets, may hold anything.
        told = b'' if status is None else os.pread(status, STATUS_AT_MOST, 0)
        return told.rpartition(b') ')[2][:1] in STOPPED
    except OSError:
        return False


def watch(pipe: int, line: int, last_words: bytes, driver: int) -> None:
    """Wait for the driver's goodbye or its death; write the last words after its death."""
    status, looks = status_of(driver), 0
    while not select.select([pipe], [], [], LOOK_EVERY)[0]:
        looks = looks + 1 if is_stopped(status) else 0
        if looks == 2:
            say(line, last_words)
    if os.read(pipe, 1) != GOODBYE:
        say(line, last_words)


def say(line: int, last_words: bytes) -> None:
    """Write to a line; be killed where it takes no bytes, do nothing where it is gone."""
    signal.alarm(PATIENCE)
    while last_words:
        # A stopped driver shares the line, so whether it blocks is not ours to change.
        select.select([], [line], [])
        try:
            last_words = last_words[os.write(line, last_words):]
        except BlockingIOError:
            continue
        except OSError:
            break
    signal.alarm(0)


if __name__ == '__main__':
    watch(int(sys.argv[1]), int(sys.argv[2]), bytes.fromhex(sys.argv[3]), int(sys.argv[4]))
