# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is done once in a period, without the executor."""

from collections.abc import Callable, Iterator
import threading

import pytest

from create_oi_ros.ros.periodic_thread import PeriodicThread
from support.ros import TIMEOUT

SHORT, LONG = 0.001, 10 * TIMEOUT
"""Periods, s: one that passes at once, and one that never ends here."""


@pytest.fixture
def failed() -> threading.Event:
    """Return what is set when the thread has ended with an error."""
    return threading.Event()


@pytest.fixture
def every(failed) -> Iterator[Callable[[float, Callable[[], None]], PeriodicThread]]:
    """Return a function that prepares such a thread; all are closed at the end."""
    made: list[PeriodicThread] = []

    def prepare(period: float, callback: Callable[[], None]) -> PeriodicThread:
        made.append(PeriodicThread('periodic', period, callback, on_failure=failed.set))
        return made[-1]
    yield prepare
    for each in made:
        each.close()


def test_it_is_called_again_and_again_on_one_thread(every, failed):
    callers, enough = [], threading.Event()

    def call() -> None:
        callers.append(threading.current_thread())
        if len(callers) == 3:
            enough.set()
    thread = every(SHORT, call)
    thread.start()
    assert enough.wait(TIMEOUT)
    assert len(set(callers)) == 1
    assert callers[0] is not threading.current_thread()
    assert not failed.is_set()


def test_close_ends_it_while_it_waits_and_twice_and_unstarted(every, failed):
    calls: list[int] = []
    never, thread = every(LONG, lambda: calls.append(1)), every(LONG, lambda: calls.append(2))
    thread.start()
    for each in (never, thread, thread):
        each.close()
    assert calls == []
    assert not [each for each in threading.enumerate() if each.name == 'periodic']
    assert not failed.is_set()


def test_close_waits_for_the_function(every):
    entered, leave, left = threading.Event(), threading.Event(), threading.Event()

    def call() -> None:
        entered.set()
        assert leave.wait(TIMEOUT)
        left.set()
    thread = every(SHORT, call)
    thread.start()
    assert entered.wait(TIMEOUT)
    threading.Timer(0.1, leave.set).start()
    thread.close()
    assert left.is_set()


def test_an_error_in_the_function_is_told_and_printed(every, failed, monkeypatch):
    printed: list[threading.ExceptHookArgs] = []
    monkeypatch.setattr(threading, 'excepthook', printed.append)

    def call() -> None:
        raise ValueError('wrong')
    thread = every(SHORT, call)
    thread.start()
    assert failed.wait(TIMEOUT)
    thread.close()
    assert [str(each.exc_value) for each in printed] == ['wrong']
