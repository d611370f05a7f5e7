# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The driver's state: a table that is complete, and a driver that never leaves it."""

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.driver.state import Activity, Owner, OWNERS, State, StateEvent, TRANSITIONS
from support.loop import Loop


def reachable(start: Activity) -> set[Activity]:
    """Return all activities that events lead to."""
    found, new = {start}, [start]
    while new:
        nexts = set(TRANSITIONS[new.pop()].values()) - found
        found |= nexts
        new += nexts
    return found


def test_every_activity_has_a_row_in_every_table():
    assert TRANSITIONS.keys() == OWNERS.keys() == set(Activity)


@pytest.mark.parametrize('activity', Activity)
def test_every_activity_can_be_reached_and_left(activity):
    assert activity in reachable(Activity.CLOSED)
    assert Activity.CLOSED in reachable(activity)


@pytest.mark.parametrize('activity', Activity)
def test_a_port_that_closes_ends_everything(activity):
    state = State(activity)
    state.handle(StateEvent.PORT_CLOSED)
    assert state.activity is Activity.CLOSED
    assert state.owner is Owner.NOBODY


@pytest.mark.parametrize('activity', list(Activity)[1:])
def test_a_robot_that_does_not_answer_is_called(activity):
    state = State(activity)
    state.handle(StateEvent.NO_ANSWER)
    assert state.activity is Activity.CALLING


@pytest.mark.parametrize('activity', Activity)
@pytest.mark.parametrize('event', StateEvent)
def test_only_a_velocity_and_a_goal_make_the_wheels_turn(activity, event):
    state = State(activity)
    if state.handle(event) and state.moving:
        assert (activity, event) in (
            (Activity.IDLE, StateEvent.VELOCITY), (Activity.IDLE, StateEvent.GOAL_STARTED),
            (Activity.DRIVING, StateEvent.GOAL_STARTED), (Activity.DEMO, StateEvent.GOAL_STARTED))


@pytest.mark.parametrize('activity', Activity)
def test_who_takes_no_commands_says_why(activity):
    state = State(activity)
    assert state.takes_commands == (state.refusal is None)
    assert state.takes_commands or state.drive_refusal
    if state.owner is Owner.ROBOT:
        assert state.drive_refusal


@given(st.lists(st.sampled_from(StateEvent)))
def test_an_event_that_the_table_does_not_list_changes_nothing(events):
    state = State()
    for event in events:
        before = state.activity
        changed = state.handle(event)
        assert changed == (state.activity is not before)
        assert not changed or TRANSITIONS[before][event] is state.activity


def test_the_activity_follows_what_is_asked_for():
    loop, seen = Loop(), []
    driver = loop.driver

    def note(seconds: float) -> None:
        loop.run(seconds)
        seen.append(driver.state.activity)
    seen.append(driver.state.activity)
    note(0.5)
    driver.drive(0.1, 0.0, loop.now)
    note(0.1)
    driver.stop(loop.now)
    note(0.1)
    driver.demos.start(oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    note(0.1)
    driver.demos.stop()
    note(0.1)
    driver.scripts.define(oi.Script(script=oi.WaitTime(time=10).encode()))
    driver.scripts.play(loop.now, force=False)
    note(0.3)
    note(1.5)
    driver.scripts.show(loop.now)
    note(0.05)
    note(1.0)
    driver.disconnected('pulled out')
    note(0.1)
    assert seen == [
        Activity.CALLING, Activity.IDLE, Activity.DRIVING, Activity.IDLE, Activity.DEMO,
        Activity.IDLE, Activity.SCRIPT, Activity.IDLE, Activity.SILENCING, Activity.IDLE,
        Activity.CLOSED]
