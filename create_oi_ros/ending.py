"""
Ending on a signal, for programs whose main thread waits in C.

There a Python signal handler would not run until the wait is over, and rclpy's own handlers end
the context before the robot has been told goodbye. So the signals are blocked, and a thread
waits for them.
"""

from collections.abc import Callable
import signal
import threading

STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def block_signals() -> None:
    """Hold the signals back; call it before any other thread is started."""
    signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)


def call_on_signal(end: Callable[[], None]) -> None:
    """Call `end` on a thread of its own when the first of the signals comes."""
    def wait() -> None:
        signal.sigwait(STOPPING)
        end()
    threading.Thread(target=wait, name='signals', daemon=True).start()
