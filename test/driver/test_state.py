# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The driver's state: a table that is complete, and a driver that never leaves it."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Severity
from create_oi_ros.driver.goal_control import TAKEN_OVER
from create_oi_ros.driver.goals import Code, Dock
from create_oi_ros.driver.outbox import CALLED_OFF, HALT
from create_oi_ros.driver.state import Activity, CONSEQUENCES, State, StateEvent, Then, TRANSITIONS
from support.goals import distance, pursue
from support.loop import Loop, said


@pytest.fixture
def loop() -> Loop:
    """Return a robot and a driver that have met a while ago."""
    met = Loop()
    met.run(3.0)
    return met


@pytest.mark.parametrize(('event', 'leads_to'), [
    (StateEvent.PORT_CLOSED, Activity.CLOSED), (StateEvent.CALLED, Activity.CALLING)])
def test_a_robot_out_of_reach_ends_everything(event, leads_to):
    for state in map(State, list(Activity)[1:]):
        state.handle(event)
        assert state.activity is leads_to and not state.answered


def test_only_a_velocity_and_a_goal_make_the_wheels_turn():
    assert {(activity, event) for activity in Activity for event in StateEvent
            if event in TRANSITIONS[activity]
            and (state := State(activity)).handle(event) is not None and state.moving} == {
        (Activity.IDLE, StateEvent.VELOCITY), (Activity.IDLE, StateEvent.GOAL_STARTED),
        (Activity.DRIVING, StateEvent.GOAL_STARTED), (Activity.DEMO, StateEvent.GOAL_STARTED)}


def test_who_takes_no_commands_says_why():
    for state in map(State, Activity):
        assert state.takes_commands == (state.refusal is None)
        assert state.takes_commands or state.drive_refusal
        assert state.drive_refusal or not state.robot_moves


# What follows from an event: no cell of the second table is empty that must not be.


CHANGES = [(State(before), event, State(after)) for before, row in TRANSITIONS.items()
           for event, after in row.items()]
"""Every change of the activity: before, event, after."""
NEWER = {StateEvent.RESTED, StateEvent.MODE_SET, StateEvent.PASSIVE_SET, StateEvent.DEMO_STARTED,
         StateEvent.DEMO_ENDED}
"""Events by which somebody asks for a mode."""


def follows(event: StateEvent, then: Then) -> bool:
    """Tell whether this follows from an event."""
    return then in CONSEQUENCES[event]


@pytest.mark.parametrize(('before', 'event', 'after'), CHANGES, ids=lambda each: (
    each.name if isinstance(each, StateEvent) else each.activity.name))
def test_what_a_change_of_the_activity_asks_for_follows_from_its_event(before, event, after):
    if before.moving and not after.moving:
        assert follows(event, Then.STAND), 'the wheels would go on'
    if not after.answered:
        assert follows(event, Then.FORGET)
    if before.robot_moves and not after.robot_moves:
        assert follows(event, Then.CALL_OFF), 'a demo would begin later'
    if before.robot_moves != after.robot_moves and after.answered:
        assert follows(event, Then.AGAIN), 'the driver would not know how the wheels turn'
    if before.pursues and not after.pursues:
        assert follows(event, Then.END) or event is StateEvent.GOAL_ENDED
        back = follows(event, Then.GIVE_BACK) or follows(event, Then.RESTORE)
        assert back is (event not in NEWER), 'the mode of the goal would stay'
        assert event in TAKEN_OVER or event in (StateEvent.GOAL_ENDED, StateEvent.MODE_LEFT)
    if after.answered and not before.answered:
        assert follows(event, Then.WARN)


def test_an_event_that_no_table_lists_is_logged_once_and_changes_nothing(loop, monkeypatch):
    monkeypatch.undo()  # what lets all other tests fail
    for _ in range(2):
        loop.driver.core.handle(StateEvent.SCRIPT_ENDED)
    loop.run(0.1)
    assert loop.driver.state.activity is Activity.IDLE
    assert said(loop, Severity.WARNING, 'SCRIPT_ENDED came in IDLE') == 1


# A stop takes queued motion out of the queue.


@pytest.mark.parametrize('demo', [oi.DemoNumber.COVER, oi.DemoNumber.COVER_AND_DOCK])
@pytest.mark.parametrize('wait', [0.0, 0.01, 0.3])
@pytest.mark.parametrize('stop', [
    lambda driver, now: driver.stop(now), lambda driver, now: driver.modes.stop_demo(),
    lambda driver, now: driver.modes.set(oi.Mode.SAFE, now),
    lambda driver, now: driver.modes.set(oi.Mode.PASSIVE, now),
    lambda driver, now: driver.shut_down(now)],
    ids=['stop', 'stop_demo', 'safe', 'passive', 'shut_down'])
def test_a_demo_that_was_stopped_never_begins_later(loop, demo, wait, stop):
    started = loop.driver.modes.start_demo(demo)
    loop.run(wait)
    waits = started.outcome is None
    stop(loop.driver, loop.now)
    assert not loop.driver.core.outbox.call_off_motion()
    loop.run(0.05)
    for _ in range(600):
        loop.turn()
        assert loop.robot.demo is None and loop.robot.actuators.wheels == (0, 0)
    assert started.outcome.ok != waits


@pytest.mark.parametrize('wait', [0.0, 0.3])
def test_a_search_for_the_dock_that_was_canceled_never_begins_later(loop, wait):
    running = loop.driver.goals.start(Dock(0.0), loop.now)
    while loop.driver.state.activity is not Activity.DOCKING:
        loop.turn()
    loop.run(wait)
    loop.driver.goals.cancel(running, loop.now)
    for _ in range(400):
        loop.turn()
        assert loop.robot.demo is None and loop.robot.actuators.wheels == (0, 0)
    assert loop.robot.mode is oi.Mode.SAFE


def test_a_script_that_was_stopped_before_it_was_sent_is_not_played(loop):
    drive = oi.DriveDirect(right=100, left=100).encode() + oi.WaitTime(time=5).encode()
    loop.driver.scripts.define(oi.Script(script=drive))
    loop.run(0.1)
    playing = loop.driver.scripts.play(loop.now, force=False)
    assert loop.driver.stop(loop.now).outcome.ok
    assert playing.outcome == (False, CALLED_OFF)
    loop.run(1.0)
    assert loop.driver.state.activity is Activity.IDLE and loop.moved
    loop.drive(0.1, 0.0, 1.0)
    assert loop.robot.actuators.wheels == (100, 100)


def test_passive_stops_a_robot_that_drives_before_anything_else(loop):
    loop.drive(0.3, 0.0, 1.0)
    loop.commands()
    loop.driver.modes.set(oi.Mode.PASSIVE, loop.now)
    loop.driver.drive(0.3, 0.0, loop.now)
    loop.turn()
    assert loop.commands()[:2] == [HALT, oi.Start()]
    assert loop.driver.state.activity is Activity.IDLE


# Commands must pause after an absence.


def test_commands_must_pause_before_a_robot_that_was_away_follows_them(loop):
    loop.drive(0.2, 0.5, 1.0)
    loop.cut = True
    loop.drive(0.2, 0.5, 3.0)
    loop.robot.receive(oi.Start().encode() + HALT.encode(), loop.now)
    loop.cut = False
    loop.drive(0.2, 0.5, 2.0)
    assert loop.robot.mode is oi.Mode.SAFE and loop.robot.actuators.wheels == (0, 0)
    assert said(loop, Severity.WARNING, 'not driving: the robot was away') == 1
    assert said(loop, Severity.WARNING, 'let commands pause and send again, or call set') == 1
    loop.run(0.7)
    loop.drive(0.2, 0.0, 1.0)
    assert loop.robot.actuators.wheels == (200, 200)


@pytest.mark.parametrize(
    ('mode', 'drives'), [(oi.Safe, True), (oi.Start, False), (oi.Full, False)])
def test_a_hiccup_needs_no_pause_unless_the_robot_comes_back_in_another_mode(loop, mode, drives):
    loop.drive(0.2, 0.0, 1.0)
    loop.cut = True
    loop.drive(0.2, 0.0, 1.5)
    loop.robot.receive(mode().encode(), loop.now)
    loop.cut = False
    loop.drive(0.2, 0.0, 2.0)
    assert any(loop.robot.actuators.wheels) is drives


def losing_replies(loop: Loop) -> None:
    """Lose all that the robot sends for 1.2 s."""
    loop.lost_down = True
    loop.drive(0.2, 0.0, 1.2)
    loop.lost_down = False


@pytest.mark.parametrize('hiccup', [
    losing_replies, lambda loop: loop.stand_still(1.2), lambda loop: loop.lose_port(1.2)],
    ids=['replies', 'driver', 'port'])
@pytest.mark.parametrize('phase', [0.0, 0.005, 0.01])
def test_a_hiccup_of_driver_port_or_line_needs_no_pause(loop, hiccup, phase):
    loop.drive(0.2, 0.0, 1.0 + phase)
    hiccup(loop)
    loop.drive(0.2, 0.0, 2.0)
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.robot.actuators.wheels == (200, 200)


@pytest.mark.parametrize('order', [
    lambda loop: loop.driver.modes.set(oi.Mode.SAFE, loop.now),
    lambda loop: pursue(loop, distance(0.1)).code is Code.NONE], ids=['mode', 'goal'])
def test_setting_the_mode_and_a_goal_are_as_good_as_a_pause(loop, order):
    loop.cut = True
    loop.drive(0.2, 0.0, 3.0)
    loop.cut = False
    loop.drive(0.2, 0.0, 1.0)
    assert loop.driver.state.activity is Activity.HOLDING
    assert order(loop)
    loop.drive(0.2, 0.0, 1.0)
    assert loop.driver.state.activity is Activity.DRIVING
