# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of all tests: the same examples in every run, and an end to every test."""

from collections.abc import Iterator
import faulthandler
import os

from hypothesis import settings
import pytest

from create_oi_ros.driver import Driver
from create_oi_ros.driver.state import StateEvent

settings.register_profile('repeatable', derandomize=True, database=None, deadline=None)
settings.load_profile('repeatable')

# Tests kill programs at any moment. What those leave in shared memory would stay, half a megabyte
# each, and can hang the tests of a later run.
os.environ['FASTDDS_BUILTIN_TRANSPORTS'] = 'UDPv4'

HANGS = 360.0
"""Seconds after which a test ends its process: pytest's timeout is shorter, and has not helped."""
STDERR = pytest.StashKey[int]()


def pytest_configure(config: pytest.Config) -> None:
    """Keep the true stderr: what a test writes to its own is not shown when its process ends."""
    capture = config.pluginmanager.getplugin('capturemanager')
    with capture.global_and_fixture_disabled():
        config.stash[STDERR] = os.dup(2)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """End the process of a test that hangs, where its own timeout does not help."""
    end_process_later(item)
    try:
        return (yield)
    finally:
        faulthandler.cancel_dump_traceback_later()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> None:
    """Begin again: pytest forgets the time when a test fails, and fixtures can hang, too."""
    end_process_later(item)


def end_process_later(item: pytest.Item) -> None:
    """After HANGS seconds, show where all threads are and exit."""
    faulthandler.dump_traceback_later(HANGS, exit=True, file=item.config.stash[STDERR])


@pytest.fixture
def unmeasured(monkeypatch):
    """Measure no coverage in the processes that a test starts: they cannot write its file."""
    monkeypatch.delenv('COVERAGE_PROCESS_CONFIG', raising=False)


@pytest.fixture(autouse=True)
def unexpected_events_fail(monkeypatch):
    """Fail where the driver's state gets an event that its tables do not list."""
    def fail(driver: Driver, event: StateEvent) -> None:
        raise AssertionError(f'{event} came in {driver.state.activity}')
    monkeypatch.setattr(Driver, '_report_unknown', fail)
