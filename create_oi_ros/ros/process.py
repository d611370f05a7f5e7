"""
Ending on a signal, for programs whose main thread waits in C.

There a Python signal handler would not run until the wait is over, and rclpy's own handlers end
the context before the robot has been told goodbye. So the interpreter notes the signal on a
socket, whichever thread it came to, and a thread of ours reads that socket.
"""

from collections.abc import Callable
import ctypes
import signal
import socket
import threading

from rclpy.executors import Executor
from rclpy.task import Future

PR_SET_PDEATHSIG = 1
"""Linux, prctl(2)."""
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def end_with_parent() -> None:
    """Have the kernel send SIGTERM when the parent process dies, however it dies (Linux)."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def call_on_signal(end: Callable[[], None]) -> None:
    """Call `end` on a thread of its own when a signal says to stop; from the main thread only."""
    noted, note = socket.socketpair()
    note.setblocking(False)

    def wait() -> None:
        noted.recv(1)
        end()
        # The sockets live as long as the handler may write to them.
        noted.recv(1)
        note.close()

    signal.set_wakeup_fd(note.fileno(), warn_on_full_buffer=False)
    for number in STOPPING:
        signal.signal(number, lambda *_: None)
    threading.Thread(target=wait, name='signals', daemon=True).start()


def spin_until(executor: Executor, ended: Future) -> None:
    """
    Run callbacks until a future is done, and end at once then.

    rclpy's own function of this kind adds a callback to the future each time round, so that a
    program that runs for days grows. `Executor.wake` does not end a wait: it takes a callback
    that is run.
    """
    bell = executor.get_nodes()[0].create_guard_condition(lambda: None)
    ended.add_done_callback(lambda _: bell.trigger())
    while not ended.done():
        executor.spin_once()
