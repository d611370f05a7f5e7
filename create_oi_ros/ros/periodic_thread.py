# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A function that is called once in a period, on a thread of its own.

A timer of rclpy does the same, but wakes the executor, which then gathers everything that it waits
for: with the services and actions of this node that takes as long as what the timer is there for.
"""

from collections.abc import Callable
import threading


class PeriodicThread:
    """Calls a function again and again, first after one period."""

    def __init__(self, name: str, period: float, callback: Callable[[], None], *,
                 on_failure: Callable[[], None]) -> None:
        """
        Prepare it, with a period in seconds; `start` begins.

        `on_failure` is called when the thread ends with an error, whose traceback is printed.
        """
        self._period = period
        self._callback = callback
        self._on_failure = on_failure
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name)

    def start(self) -> None:
        """Begin to call the function."""
        self._thread.start()

    def close(self) -> None:
        """Call it no more, and wait until it has returned."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()

    def _run(self) -> None:
        try:
            while not self._closing.wait(self._period):
                self._callback()
        finally:
            if not self._closing.is_set():
                self._on_failure()
