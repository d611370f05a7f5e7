# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of a goal's orders, byte for byte, and how each thing that ends a goal ends it."""

from collections.abc import Iterator

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity
from create_oi_ros.driver.goal_control import CLIENT_GONE, MODE_WAIT
from create_oi_ros.driver.goals import Code, Goal, Progress, Running
from create_oi_ros.driver.goals.goal import Instruction, Order, Over, View
from create_oi_ros.driver.mode import DOCK_PAUSE
from create_oi_ros.driver.motion import Velocity
from support.loop import Loop, STEP

HALT = oi.DriveDirect(right=0, left=0)
DONE = Over(Code.NONE, 'done')


class Told(Goal):
    """A goal that orders what it is told to."""

    def __init__(self, order: Order, *, allowance: float = 0.0, needs_driving: bool = True,
                 over: Over | None = None) -> None:
        super().__init__(allowance)
        self.order, self.needs_driving, self._over = order, needs_driving, over
        self.views: list[View] = []
        self.begun = 0

    def obstacle(self) -> Over | None:
        """Count how often the goal begins."""
        self.begun += 1
        return self._over

    def hazard(self) -> Over | None:
        """Count the steps."""
        self.views.append(self.view)
        self.progress = Progress(distance=len(self.views))
        return None

    def orders(self) -> Iterator[Order]:
        """Order it."""
        while True:
            yield self.order


AHEAD = Velocity(0.1, 0.0)


def sent(loop: Loop) -> list[oi.Command]:
    """Return what the robot was told since the last time, but for requests of packets."""
    return [each for each in loop.commands() if not isinstance(each, oi.Stream)]


def begun(loop: Loop, goal: Goal) -> Running:
    """Start a goal and let it take some steps."""
    running = loop.driver.goals.start(goal, loop.now)
    loop.run(0.1)
    return running


def searching(loop: Loop) -> tuple[Told, Running]:
    """Let a goal search for the dock until the robot does."""
    goal = Told(Instruction.SEEK_DOCK, needs_driving=False)
    running = loop.driver.goals.start(goal, loop.now)
    while loop.driver.state.activity is not Activity.DOCKING:
        loop.turn()
    goal.order = Instruction.GO_ON
    loop.run(DOCK_PAUSE + 0.1)
    return goal, running


def ended(running: Running) -> tuple[Code, str]:
    """Return how a goal ended: the reason, without how far it got and what to do."""
    assert running.ending is not None
    return running.ending.code, running.ending.text.rpartition('; ')[2].partition(':')[0]


def test_a_velocity_that_a_goal_orders_is_sent_and_a_goal_that_is_over_stops(at_once):
    goal = Told(AHEAD)
    running = begun(at_once, goal)
    assert goal.begun == 1
    assert sent(at_once)[-1] == oi.DriveDirect(right=100, left=100)
    assert running.ending is None and running.progress.distance == len(goal.views) > 3
    assert at_once.driver.goals.active
    goal.order = DONE
    at_once.run(2 * oi.SLOT)
    assert sent(at_once)[0] == HALT
    assert ended(running) == (Code.NONE, 'done')
    assert running.ending.seconds == pytest.approx(0.1, abs=2.5 * oi.SLOT)
    assert running.ending.estimate in [moved.estimate for moved in at_once.moved[-3:]]
    assert not at_once.driver.goals.active
    assert at_once.driver.state.activity is Activity.IDLE


def test_a_goal_that_is_over_when_it_begins_takes_no_step(at_once):
    goal = Told(AHEAD, over=DONE)
    running = begun(at_once, goal)
    assert ended(running) == (Code.NONE, 'done')
    assert goal.views == []
    assert set(sent(at_once)) == {HALT}


@pytest.mark.parametrize(('end', 'code', 'text'), [
    (lambda goals, *each: goals.cancel(*each), Code.CANCELED, 'canceled'),
    (lambda goals, *each: goals.cancel(*each, CLIENT_GONE), Code.STOPPED, 'its client has gone')])
def test_only_the_goal_that_runs_can_be_ended_by_its_client(at_once, end, code, text):
    goals = at_once.driver.goals
    first = begun(at_once, Told(AHEAD))
    second = begun(at_once, Told(AHEAD))
    assert ended(first) == (Code.SUPERSEDED, 'another goal took over')
    sent(at_once)
    end(goals, first, at_once.now)
    at_once.run(0.1)
    assert second.ending is None and HALT not in sent(at_once)
    end(goals, second, at_once.now)
    at_once.turn()
    assert ended(second) == (code, text)
    assert sent(at_once)[0] == HALT
    at_once.run(0.1)
    sent(at_once)
    end(goals, second, at_once.now)
    at_once.run(0.1)
    assert sent(at_once) == [], 'a goal that has ended is not ended again'


def test_a_goal_ends_when_its_time_is_over_and_not_before(at_once):
    running = at_once.driver.goals.start(Told(AHEAD, allowance=0.5), at_once.now)
    at_once.run(0.5 - STEP)
    assert running.ending is None
    at_once.run(2 * oi.SLOT)
    assert ended(running) == (Code.TIMEOUT, 'time_allowance of 0.5 s is over')
    assert HALT in sent(at_once)
    endless = begun(at_once, Told(AHEAD))
    at_once.run(2.0)
    assert endless.ending is None


def test_a_goal_waits_for_its_mode_and_then_has_all_its_time(loop):
    loop.run(2.0)
    loop.robot.receive(oi.Start().encode(), loop.now)
    loop.run(1.5)
    hear, loop.robot.receive = loop.robot.receive, lambda *_: None
    running = loop.driver.goals.start(goal := Told(AHEAD, allowance=0.5), loop.now)
    loop.run(0.3)
    assert goal.begun == 0
    loop.robot.receive = hear
    hear(oi.Safe().encode(), loop.now)  # only now the robot takes what it was sent
    loop.run(0.45)
    assert running.ending is None and goal.begun == 1
    loop.run(0.5)
    assert ended(running)[0] is Code.TIMEOUT


def test_a_goal_whose_mode_does_not_come_is_given_up(loop):
    loop.run(2.0)
    loop.robot.receive(oi.Start().encode(), loop.now)
    loop.run(1.5)
    loop.robot.receive = lambda *_: None
    running = loop.driver.goals.start(goal := Told(AHEAD), loop.now)
    loop.run(MODE_WAIT - 0.01)
    assert running.ending is None
    loop.run(0.03)
    assert ended(running) == (Code.MODE, 'robot is in PASSIVE')
    assert goal.begun == 0


def test_another_goal_takes_over_from_a_search_for_the_dock_and_drives(at_once):
    _, search = searching(at_once)
    running = at_once.driver.goals.start(Told(AHEAD), at_once.now)
    assert ended(search) == (Code.SUPERSEDED, 'another goal took over')
    at_once.run(0.3)
    assert running.ending is None
    assert at_once.robot.mode is oi.Mode.SAFE and at_once.robot.actuators.wheels == (100, 100)


def test_a_goal_is_as_good_as_a_pause_of_commands(at_once):
    at_once.cut = True
    at_once.drive(0.2, 0.0, 3.0)
    at_once.cut = False
    at_once.drive(0.2, 0.0, 1.0)
    assert at_once.driver.state.activity is Activity.HOLDING
    begun(at_once, Told(AHEAD))
    assert at_once.robot.actuators.wheels == (100, 100)


def test_a_goal_ends_when_the_robot_enters_no_mode_to_drive_in_while_it_runs(at_once):
    running = begun(at_once, Told(AHEAD))
    at_once.driver.modes.set(oi.Mode.FULL, at_once.now)
    at_once.forged = {'oi_mode': int(oi.Mode.PASSIVE)}
    at_once.run(0.2)
    assert ended(running)[0] is Code.MODE
    assert at_once.robot.actuators.wheels == (0, 0)
