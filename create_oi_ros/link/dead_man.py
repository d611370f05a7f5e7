"""
A process that stops the wheels when the driver dies.

The Open Interface has no timeout: a robot whose driver is killed drives on for ever. So a second,
small process holds the line open too and waits on a pipe from the driver. A driver that ends
normally writes a goodbye to the pipe. If the pipe closes without it, the driver is dead, however
it died, and this process writes the bytes that stop the robot.

It also writes them when the driver is suspended (Ctrl-Z, SIGSTOP, a debugger), since nobody is in
command then: at once, and again every second, as the driver may run for a moment in between and
be suspended again. It keeps watching.

`DeadMan` is the driver's side. Run as a program, this file is the process. It uses little of the
standard library, so that it starts in a few milliseconds, before anything moves.
"""

import os
import select
import signal
import subprocess
import sys

GOODBYE = b'\0'
END_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
WRITE_TIMEOUT = 2
"""Seconds after which the process gives up on a line that takes no bytes."""
CHECK_INTERVAL = 0.04
"""Seconds between two checks whether the driver is suspended; two in a row must find it so."""
CHECKS_TO_REPEAT = 25
"""Checks between two times that the last words are written while the driver stays suspended."""
SUSPENDED = (b'T', b't')
"""Process states: stopped by a signal, and by a debugger (proc(5))."""
STATUS_LIMIT = 4096


class DeadMan:
    """Watches over one open line until `release` or `say_last_words`."""

    def __init__(self, line: int, last_words: bytes) -> None:
        """Start the process; `line` is the file descriptor, `last_words` what stops the robot."""
        watched, self._pipe = os.pipe()
        # The process inherits the mask, so the signals that end its parent never reach it.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, END_SIGNALS)
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
        """The process id."""
        return self._process.pid

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
            self.say_last_words()

    def say_last_words(self) -> None:
        """End the process after it has stopped the robot, if the line still takes bytes."""
        os.close(self._pipe)
        self._process.wait()


def open_status(process: int) -> int | None:
    """Open the kernel's status file of a process; None for one that is gone or hidden."""
    try:
        return os.open(f'/proc/{process}/stat', os.O_RDONLY)
    except OSError:
        return None


def is_suspended(status: int | None) -> bool:
    """Tell whether a process is suspended; one that is gone or hidden is not."""
    try:
        # The process name, in brackets, may hold anything.
        text = b'' if status is None else os.pread(status, STATUS_LIMIT, 0)
        return text.rpartition(b') ')[2][:1] in SUSPENDED
    except OSError:
        return False


def watch(pipe: int, line: int, last_words: bytes, driver: int) -> None:
    """Wait for the driver's goodbye or its death; write the last words after its death."""
    status, found = open_status(driver), 0
    while not select.select([pipe], [], [], CHECK_INTERVAL)[0]:
        found = found + 1 if is_suspended(status) else 0
        if found % CHECKS_TO_REPEAT == 2:
            write_all(line, last_words)
    if os.read(pipe, 1) != GOODBYE:
        write_all(line, last_words)


def write_all(line: int, last_words: bytes) -> None:
    """Write to a line; end the process if the line takes no bytes, do nothing if it is gone."""
    signal.alarm(WRITE_TIMEOUT)
    while last_words:
        # A suspended driver shares the open line, so its blocking mode must stay as it is.
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
