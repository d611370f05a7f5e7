# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""However a driver ends, its robot stops: in the model always, and its steps are the real ones."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import signal
import subprocess
import sys
import threading
import time

import pytest

from create_oi_ros.robot import Rounding
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.world import shipped
from support.end_model import explore, Found, State, steps
from support.ros import Robot, TIMEOUT


@pytest.fixture(scope='module')
def found() -> Found:
    """Visit all states once."""
    return explore(2)


@pytest.mark.nightly
@pytest.mark.timeout(3600)
def test_no_order_of_steps_with_three_faults_leaves_a_robot_driving():
    assert explore(3).bad is None


def test_no_order_of_steps_leaves_a_robot_driving(found):
    assert found.bad is None, ' > '.join(found.bad)
    assert found.states > 10_000
    assert found.ends > 100


# The same steps with real processes: a driver's session, its dead-man, a terminal, a robot.

DRIVER = """
import sys
import threading
from create_oi_ros.driver import Driver, MotionLimits, Settings
from create_oi_ros.link import session as module
from create_oi_ros.link.port import Port, PortError
module.LEAST_LIFE = 0.0  # a dead-man is replaced however soon it ended
failing, news = [], threading.Event()
class AnyPort(Port):
    def write(self, encoded):
        if failing:
            failing.clear()
            raise PortError('a write that fails once')
        super().write(encoded)
session = module.Session(
    Driver(Settings(limits=MotionLimits(timeout=1000.0))), sys.argv[1],
    on_event=lambda _: news.set(), on_failure=lambda: None, dead_man=True, open_port=AnyPort)
session.start()
for line in sys.stdin:
    word = line.strip()
    if word == 'fail':
        failing.append(True)
    elif word == 'end':
        session.close()
        break
    while word in ('drive', 'stop'):
        news.clear()
        with session.request() as (driver, now):
            driver.drive(0.3 if word == 'drive' else 0.0, 0.0, now)
            if driver.state.moving == (word == 'drive'):
                break
        news.wait(30)
"""


class Real:
    """A driver in a process of its own, and its robot."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._process = subprocess.Popen(
            [sys.executable, '-c', DRIVER, str(robot.link)], stdin=subprocess.PIPE, text=True)
        self.pid = self._process.pid
        self.until(lambda: self.robot.create.mode.name == 'SAFE')

    def say(self, word: str) -> None:
        """Tell the driver's process what to do."""
        assert self._process.stdin is not None
        self._process.stdin.write(f'{word}\n')
        self._process.stdin.flush()

    def until(self, happened: Callable[[], object]) -> None:
        """Wait until something has happened; look after each of the robot's slots."""
        deadline = time.monotonic() + TIMEOUT
        while not happened():
            slot = threading.Event()
            self.robot.soon(slot.set)
            assert slot.wait(max(0.0, deadline - time.monotonic()))

    @property
    def drives(self) -> bool:
        """Whether the robot's wheels are asked to turn."""
        return any(self.robot.create.actuators.wheels)

    def drive(self) -> None:
        """Let it drive."""
        self.say('drive')
        self.until(lambda: self.drives)

    def dead_man(self) -> int:
        """Return the process id of the dead-man."""
        found: list[int] = []

        def look() -> list[int]:
            found[:] = self._children()
            return found
        self.until(look)
        return found[0]

    def _children(self) -> list[int]:
        # The session's own thread starts it.
        listed = [task.read_text() for task in Path(f'/proc/{self.pid}/task').glob('*/children')]
        return [int(child) for child in ' '.join(listed).split()]

    def end(self) -> None:
        """Wait for the end of the driver's process."""
        assert self._process.wait(TIMEOUT) is not None

    def close(self) -> None:
        """End what still runs."""
        self._process.send_signal(signal.SIGCONT)
        self._process.kill()
        self._process.communicate()


@contextmanager
def real(folder: Path) -> Iterator[Real]:
    """Yield a driver that is connected to its robot."""
    robot = Robot(folder / 'tty', shipped('empty'), Rounding.CARRY, DEFAULT_BODY)
    try:
        made = Real(robot)
        try:
            yield made
        finally:
            made.close()
    finally:
        robot.close()


START = ('node opens', 'node starts dead-man', 'node wakes the robot', 'node writes')
DRIVES = ('node drives', 'node writes')
LAST_WORDS = ('dead-man hears the end', 'dead-man writes', 'dead-man ends')


def killed(it: Real) -> None:
    """Kill the node."""
    it.drive()
    os.kill(it.pid, signal.SIGKILL)
    it.end()
    it.until(lambda: not it.drives)


def suspended(it: Real) -> None:
    """Suspend the node, continue it, and suspend it again when it drives on."""
    it.drive()
    os.kill(it.pid, signal.SIGSTOP)
    it.until(lambda: not it.drives)
    os.kill(it.pid, signal.SIGCONT)
    it.until(lambda: it.drives)
    os.kill(it.pid, signal.SIGSTOP)
    it.until(lambda: not it.drives)


def ended(it: Real) -> None:
    """Stop the wheels, drive again, and end the node."""
    it.drive()
    it.say('stop')
    it.until(lambda: not it.drives)
    it.drive()
    dead_man = it.dead_man()
    it.say('end')
    it.end()
    assert not it.drives
    assert not Path(f'/proc/{dead_man}').exists()


def fails(it: Real) -> None:
    """Let a write fail once, on a line that is whole."""
    it.drive()
    dead_man = it.dead_man()
    it.say('fail')
    it.say('stop')
    it.until(lambda: not it.drives and it.dead_man() != dead_man)


def pulled(it: Real) -> None:
    """Pull the cable, and plug it in again."""
    it.drive()
    dead_man = it.dead_man()
    it.robot.unplug()
    it.until(lambda: not Path(f'/proc/{dead_man}').exists())
    it.robot.plug()
    it.until(lambda: not it.drives)


def unguarded(it: Real) -> None:
    """Kill the dead-man, and the node when it has started another."""
    dead_man = it.dead_man()
    os.kill(dead_man, signal.SIGKILL)
    it.until(lambda: it.dead_man() != dead_man)
    killed(it)


SUSPENDED = ('node is suspended', 'dead-man suspects', 'dead-man sees it suspended',
             'dead-man writes', 'node is continued', 'node writes', 'dead-man sees it run')
REOPENED = ('node closes', *START)
SCENES = {
    killed: (*DRIVES, 'node is killed', *LAST_WORDS),
    suspended: (*DRIVES, *SUSPENDED, *SUSPENDED[:4]),
    ended: (*DRIVES, 'node stops', 'node writes', *DRIVES, 'node ends', 'node writes',
            'node says goodbye', 'dead-man hears goodbye', 'node closes'),
    fails: (*DRIVES, 'node stops', 'write fails', 'node gives up the line', *LAST_WORDS,
            *REOPENED),
    pulled: (*DRIVES, 'cable is pulled', 'node stops', 'node writes', 'node gives up the line',
             'dead-man hears the end', 'dead-man fails to write', 'dead-man ends',
             'cable is plugged in', *REOPENED),
    unguarded: ('dead-man is killed', 'node starts dead-man', *DRIVES, 'node is killed',
                *LAST_WORDS),
}


@pytest.mark.parametrize('scene', SCENES)
def test_each_step_is_run_for_real_and_ends_as_in_the_model(scene, tmp_path):
    with real(tmp_path) as it:
        scene(it)
        assert not it.drives
    assert not any(state.robot.drives for state in modelled((*START, *SCENES[scene])))


def modelled(names: tuple[str, ...]) -> set[State]:
    """Return where these steps lead; a write is run to its end."""
    states = {State()}
    for name in names:
        states = taken(states, name)
        assert states, f'the model knows no {name!r} there'
        while name.endswith(' writes') and (more := taken(states, name)):
            states = more
    return states


def taken(states: set[State], name: str) -> set[State]:
    """Return the states after a step."""
    return {after for state in states for step, after in steps(state, 9) if step == name}


def test_the_scenes_take_every_step_of_the_model(found):
    assert found.names == set(START).union(*SCENES.values())
