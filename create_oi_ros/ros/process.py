# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Start and end of a program that uses rclpy: signals, rclpy itself, and waiting for the end.

A Python signal handler runs in the main thread only, and not while that waits in C. rclpy's own
handlers shut rclpy down before the driver has stopped the robot. So here Python writes each signal
to a socket, whichever thread receives it, and a thread of ours reads that socket.
"""

import atexit
from collections.abc import Callable, Iterator
from contextlib import contextmanager
import ctypes
import faulthandler
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor, TimeoutException
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from .programs import check_environment, PROGRAMS

PR_SET_PDEATHSIG = 1
"""Linux, prctl(2)."""
SPIN_TIME = 0.05
"""Seconds for which `spin_ready` runs callbacks at most."""
END_TIME = 10.0
"""Seconds in which ROS must have shut down."""
STDERR = 2
"""Its file descriptor: `sys.stderr` need not have one."""
STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def call_on_signal(end: Callable[[], object]) -> None:
    """Call `end` on a thread of its own at the first stop signal; from the main thread only."""
    reader, writer = socket.socketpair()
    writer.setblocking(False)

    def wait() -> None:
        while (received := reader.recv(1)) and received[0] not in STOP_SIGNALS:
            pass  # the program itself handles this signal
        end()
        with writer:  # stays open: Python writes every later signal to it
            while reader.recv(1):
                pass

    signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    for number in STOP_SIGNALS:
        signal.signal(number, lambda *_: None)
        # A program that ends by one signal must not be killed by the next, as `ros2 launch` sends.
        atexit.register(signal.signal, number, signal.SIG_IGN)
    threading.Thread(target=wait, name='signals', daemon=True).start()


def stop_signals_as_ctrl_c() -> Callable[[], None]:
    """Let SIGTERM and SIGHUP do what Ctrl-C does, in the main thread; return what ends that."""
    if threading.current_thread() is not threading.main_thread():
        return lambda: None
    before = {number: signal.signal(number, lambda *_: signal.raise_signal(signal.SIGINT))
              for number in (signal.SIGTERM, signal.SIGHUP)}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)
    return restore


@contextmanager
def end_in_time() -> Iterator[None]:
    """
    Exit with code 1, after the traceback of each thread, if the body takes longer than `END_TIME`.

    For the end of ROS: Fast DDS 2.14 can wait for itself for ever when a node is destroyed while
    another program leaves. That keeps Python from everything, so the limit needs no Python.
    """
    faulthandler.dump_traceback_later(END_TIME, exit=True, file=STDERR)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


@contextmanager
def ros_executor(arguments: list[str] | None = None) -> Iterator[SingleThreadedExecutor]:
    """
    Initialise rclpy and yield an executor; at the end, destroy its nodes and shut rclpy down.

    rclpy installs no signal handlers: use `call_on_signal`. Create the nodes inside and add them
    to the executor. What must end before ROS does, such as the robot's wheels, ends inside too.
    UserError: something in the environment is wrong.
    """
    check_environment()
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    executor = SingleThreadedExecutor()
    try:
        yield executor
    finally:
        with end_in_time():
            nodes = executor.get_nodes()
            executor.shutdown()
            for node in nodes:
                node.destroy_node()
            rclpy.shutdown()


def spin_until(executor: Executor, ended: Future) -> None:
    """
    Run callbacks until a future is done, then return at once.

    `Executor.spin_until_future_complete` adds a callback to the future in every round, so memory
    grows for days. `Executor.wake` does not end a wait; a guard condition with a callback does.
    """
    bell = executor.get_nodes()[0].create_guard_condition(lambda: None)
    ended.add_done_callback(lambda _: bell.trigger())
    while not ended.done():
        executor.spin_once()


def spin_ready(executor: SingleThreadedExecutor) -> None:
    """Run the callbacks that are ready, without waiting for more."""
    until = time.monotonic() + SPIN_TIME
    while time.monotonic() < until:
        try:
            callback, _, _ = executor.wait_for_ready_callbacks(timeout_sec=0.0)
        except TimeoutException:
            return
        callback()
        callback.result()


TERMINATION_TIMEOUT = 1.5
"""Seconds that a child has to end by itself after SIGTERM, before it is killed."""


def start(program: str, *arguments: str, stdout: int | None = None) -> subprocess.Popen[bytes]:
    """Start a program that ends with this process; the terminal's Ctrl-C does not reach it."""
    parent = os.getpid()

    def end_with_parent() -> None:  # Linux sends SIGTERM, however the parent dies
        # Until exec this process has its parent's handlers, which would take the signal and go on.
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
        # The kernel tells nothing of a parent that died before the call.
        if os.getppid() != parent:
            os.kill(os.getpid(), signal.SIGTERM)
    return subprocess.Popen(
        [sys.executable, '-c', PROGRAMS[program], *arguments], stdout=stdout,
        start_new_session=True, preexec_fn=end_with_parent)


class Children:
    """Child processes, ended in the reverse order of their start."""

    def __init__(self) -> None:
        self._processes: list[tuple[str, subprocess.Popen[bytes]]] = []

    def start(self, program: str, *arguments: str, stdout: int | None = None) -> None:
        self._processes.insert(0, (program, start(program, *arguments, stdout=stdout)))

    def ended(self) -> str | None:
        """Return a sentence about a child that has ended by itself; None while all run."""
        for program, process in self._processes:
            if process.poll() is not None:
                return f'{program} has ended with exit code {process.returncode}'
        return None

    def end(self) -> None:
        """End all children, the newest first: start the node last, it has to stop the robot."""
        for _, process in self._processes:
            if process.poll() is None:
                process.terminate()  # SIGINT while Python starts would print a traceback
            try:
                process.wait(TERMINATION_TIMEOUT)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
