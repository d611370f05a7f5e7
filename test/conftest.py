# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Settings of all tests: the same examples in every run, and an end to every test."""

from collections.abc import Iterator
import faulthandler
import os
from pathlib import Path
import sys

from hypothesis import Phase, settings
import pytest

from create_oi_ros.driver.core import Core
from create_oi_ros.driver.state import StateEvent

settings.register_profile('repeatable', derandomize=True, database=None, deadline=None)
settings.register_profile(  # for mutants: nobody reads how they fail, so nothing is shrunk
    'unshrunk', settings.get_profile('repeatable'),
    phases=(Phase.explicit, Phase.generate), report_multiple_bugs=False)
settings.load_profile('repeatable')

# Tests kill programs at any moment. What those leave in shared memory would stay, half a megabyte
# each, and can hang the tests of a later run.
os.environ['FASTDDS_BUILTIN_TRANSPORTS'] = 'UDPv4'

HANGS = 1.5
"""Times its own timeout after which a test ends its process: the timeout has not helped."""
STDERR = pytest.StashKey[int]()
MAY_LACK = ('no Chromium', 'no `ros2 security`', 'not a clone of git',
            *([] if 'CREATE_OI_ROS2' in os.environ else ['no `ros2` here']))
"""
Words in the reasons for a skip that `make` cannot help; all else it installs.

`.ci/run` sets the variable where it has installed `ros2`.
"""
MADE = Path(sys.prefix) / 'ready_for_tests'
"""Where `make test` has installed what tests need, there is this file."""


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
    """Show where all threads are and exit, some time after the test's own timeout."""
    mark = item.get_closest_marker('timeout')
    timeout = mark.args[0] if mark else float(item.config.getini('timeout'))
    faulthandler.dump_traceback_later(
        HANGS * timeout, exit=True, file=item.config.stash[STDERR])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Iterator[None]:
    """Fail a test that is skipped where `make` has installed what it needs."""
    return without_excuse((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Iterator[None]:
    """Fail a file that is skipped, too."""
    return without_excuse((yield))


def without_excuse(report):
    """Return a report; one of a skip becomes a failure unless something may be missing."""
    if report.skipped and not hasattr(report, 'wasxfail') and MADE.exists():
        reason = report.longrepr[2]
        if not any(words in reason for words in MAY_LACK):
            report.outcome, report.longrepr = 'failed', f'skipped, with `make`: {reason}'
    return report


@pytest.fixture
def stage(tmp_path):
    """Return an empty scene: a ROS domain of its own, for robots and programs."""
    from support.ros import scene  # not for tests without ROS
    with scene(tmp_path) as made:
        yield made


@pytest.fixture(scope='module')
def shared_stage(tmp_path_factory):
    """Return a scene that the tests of a file share."""
    from support.ros import scene  # not for tests without ROS
    with scene(tmp_path_factory.mktemp('stage')) as made:
        yield made


@pytest.fixture(scope='module')
def ros2(tmp_path_factory):
    """Return the real `ros2` commands, in a scene that the tests of a file share."""
    from support.ros2 import real_tools  # not for tests without ROS
    with real_tools(tmp_path_factory.mktemp('ros2')) as made:
        yield made


@pytest.fixture
def unmeasured(monkeypatch):
    """Measure no coverage in the processes that a test starts: they cannot write its file."""
    monkeypatch.delenv('COVERAGE_PROCESS_CONFIG', raising=False)


@pytest.fixture(autouse=True)
def unexpected_events_fail(monkeypatch):
    """Fail where the driver's state gets an event that its tables do not list."""
    def fail(core: Core, event: StateEvent) -> None:
        raise AssertionError(f'{event} came in {core.state.activity}')
    monkeypatch.setattr(Core, '_report_unknown', fail)
