# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the goals about the Home Base order, frame by frame."""

from dataclasses import replace

import pytest

from create_oi_ros import oi
from create_oi_ros.driver.goals import Code, Dock, Phase, Undock
from create_oi_ros.driver.goals.approach import Learned
from create_oi_ros.driver.goals.goal import DockDemo, Enter, Over
from create_oi_ros.driver.motion import Velocity
from create_oi_ros.odometry import Estimate
from support.views import LIMITS, view

ON = {'charging_sources': 2}
PASSIVE, SAFE, FULL = (int(mode) for mode in (oi.Mode.PASSIVE, oi.Mode.SAFE, oi.Mode.FULL))
DT = 0.125


def at(estimate: Estimate | None = None, **readings: int):
    """Return a view of a frame of an eighth of a second."""
    return view(DT, estimate=estimate, **readings)


# Finding it.


def test_the_demo_is_played_once_and_goes_on():
    goal = Dock(0.0)
    assert goal.allowance == 240.0 and Dock(9.0).allowance == 9.0
    assert goal.begin(at()) is None
    assert [goal.step(at(oi_mode=PASSIVE)) for _ in range(3)] == [
        DockDemo.PLAY, DockDemo.GO_ON, DockDemo.GO_ON]


def test_a_wheel_in_the_air_ends_a_search():
    lifted = at(bumps_and_wheel_drops=16)
    assert Dock(0.0).begin(lifted).code is Code.WHEEL_DROP
    assert Dock(0.0).step(lifted).code is Code.WHEEL_DROP


@pytest.mark.parametrize(('state', 'says'), [
    (1, 'docked; the battery charges'), (2, 'docked; the battery charges'),
    (3, 'docked; the battery is full'), (4, 'docked; the battery is full')])
def test_a_robot_that_charges_is_docked(state, says):
    over = Dock(0.0).step(at(oi_mode=PASSIVE, charging_state=state, **ON))
    assert over == Over(Code.NONE, says)


@pytest.mark.parametrize('state', [0, 5])
def test_a_robot_on_its_contacts_charges_within_four_seconds_or_never(state):
    goal, docked = Dock(0.0), at(oi_mode=PASSIVE, charging_state=state, **ON)
    assert [goal.step(docked) for _ in range(32)] == 32 * [DockDemo.GO_ON]
    assert 'docked, but the battery does not charge' in goal.step(docked).text
    again = Dock(0.0)
    for _ in range(3):  # contacts that are lost begin anew
        assert {again.step(docked) for _ in range(31)} == {DockDemo.GO_ON}
        again.step(at(oi_mode=PASSIVE))


def test_on_its_contacts_it_enters_passive():
    assert Dock(0.0).step(at(oi_mode=FULL, charging_state=1, **ON)) == Enter(oi.Mode.PASSIVE)


@pytest.mark.parametrize(('infrared', 'phase', 'shown'), [
    (None, Phase.LOOKING, 240), (255, Phase.LOOKING, 240), (240, Phase.LOOKING, 240),
    (241, Phase.SEES_DOCK, 241), (254, Phase.SEES_DOCK, 254), (130, Phase.LOOKING, 240)])
def test_which_beam_is_seen_is_told(infrared, phase, shown):
    goal = Dock(7.0)
    goal.step(at(oi_mode=PASSIVE, **({} if infrared is None else {'infrared': infrared})))
    assert (goal.progress.phase, goal.progress.infrared) == (phase, shown)
    goal.step(at(oi_mode=PASSIVE, infrared=255))
    seen = phase is Phase.SEES_DOCK
    over = goal.timed_out()
    assert over.code is (Code.TIMEOUT if seen else Code.NO_DOCK)
    assert over.text.startswith('the Home Base was seen, but not reached in 7 s' if seen else
                                'no beam of a Home Base was seen in 7 s')


@pytest.mark.parametrize(('state', 'phase'), [
    (0, Phase.DOCKED), (5, Phase.DOCKED), (1, Phase.CHARGING), (4, Phase.CHARGING)])
def test_a_docked_robot_is_told_whether_it_charges(state, phase):
    goal = Dock(0.0)
    goal.step(at(oi_mode=PASSIVE, charging_state=state, infrared=255, **ON))
    assert goal.progress.phase is phase


# Leaving it.


def undock(mode: int = SAFE) -> Undock:
    """Return a goal that has begun on the dock."""
    goal = Undock(0.0, Learned())
    assert goal.begin(at(oi_mode=mode, **ON)) is None
    return goal


def test_it_begins_on_a_dock_with_wheels_that_may_turn_and_nothing_in_the_air():
    assert Undock(0.0, Learned()).begin(at()).code is Code.NO_DOCK
    stands = replace(LIMITS, max_wheel_speed=0.0)
    assert Undock(0.0, Learned()).begin(view(limits=stands, **ON)).code is Code.STALL
    assert Undock(0.0, Learned()).begin(at(bumps_and_wheel_drops=8, **ON)).code is Code.WHEEL_DROP
    for felt in ({'bumps_and_wheel_drops': 3}, {'cliff_left': 1}):
        assert Undock(0.0, Learned()).begin(at(**felt, **ON)) is None


def test_it_may_take_twice_what_it_should():
    goal = undock()
    limits = view().limits
    ramps = 0.05 * (1 / min(0.5, limits.linear_acceleration or 0.5) + 1 / min(
        0.25, limits.linear_acceleration or 0.25))
    assert goal.allowance == pytest.approx(
        2 * (3.0 + ramps + 4 * (1.4 + 0.02 / 0.03) + 1.5 + 1.2))
    given = Undock(7.0, Learned())
    given.begin(at(**ON))
    assert given.allowance == 7.0


def test_in_safe_it_drives_backwards_and_is_done_where_it_has_left():
    goal = undock()
    first = goal.step(at(**ON))
    assert first.linear < 0
    for _ in range(9):
        goal.step(at(Estimate(linear=-0.1), **ON))
    assert goal.step(at(Estimate(x=-0.3))) == Velocity(0.0, 0.0)
    for _ in range(12):
        over = goal.step(at(Estimate(x=-0.3)))
    assert over == Over(Code.NONE, 'left the dock')


def test_a_robot_that_still_feels_its_contacts_has_taken_them_along():
    goal = undock(FULL)
    for _ in range(14):
        over = goal.step(at(Estimate(x=-0.3), oi_mode=FULL, **ON))
    assert over.code is Code.STALL and 'takes the dock along' in over.text


def test_it_enters_safe_and_waits_for_it_then_full():
    goal = undock(PASSIVE)
    assert goal.step(at(oi_mode=PASSIVE, **ON)) == Enter(oi.Mode.SAFE)
    assert [goal.step(at(oi_mode=PASSIVE, **ON)) for _ in range(4)] == 4 * [Velocity()]
    order = goal.step(at(oi_mode=PASSIVE, **ON))
    assert (order.mode, order.why) == (oi.Mode.FULL, (
        'docked, the robot does not stay in SAFE: it leaves the dock in FULL, then returns to '
        'SAFE'))
    assert [goal.step(at(oi_mode=PASSIVE, **ON)) for _ in range(4)] == 4 * [Velocity()]
    over = goal.step(at(oi_mode=PASSIVE, **ON))
    assert over.code is Code.MODE and 'does not enter FULL' in over.text


def test_a_robot_that_safe_holds_goes_by_full_and_returns():
    goal = undock()
    for _ in range(12):
        assert isinstance(goal.step(at(**ON)), Velocity)
    order = goal.step(at(**ON))
    assert order.mode is oi.Mode.FULL
    assert order.why.startswith('docked in SAFE the robot does not move: it leaves')
    assert goal.step(at(oi_mode=FULL, **ON)).linear < 0
    assert goal.step(at(Estimate(x=-0.1), oi_mode=FULL)) == Enter(oi.Mode.SAFE)
    assert goal.step(at(Estimate(x=-0.1))).linear < 0
    for _ in range(14):
        over = goal.step(at(Estimate(x=-0.3)))
    assert over == Over(Code.NONE, 'left the dock, by FULL, now in SAFE again')


def test_a_robot_in_full_stays_there():
    goal = undock(FULL)
    for _ in range(14):
        over = goal.step(at(Estimate(x=-0.3), oi_mode=FULL))
    assert over == Over(Code.NONE, 'left the dock')


def test_away_from_the_dock_a_mode_that_is_not_entered_ends_it():
    goal = undock()
    goal.step(at(**ON))
    assert goal.step(at(oi_mode=PASSIVE)) == Enter(oi.Mode.SAFE)
    assert [goal.step(at(oi_mode=PASSIVE)) for _ in range(4)] == 4 * [Velocity()]
    assert 'does not enter SAFE' in goal.step(at(oi_mode=PASSIVE)).text


def test_a_bumper_counts_once_the_dock_cannot_press_it():
    goal = undock()
    for pressed in (3, 0, 3):
        assert isinstance(goal.step(at(bumps_and_wheel_drops=pressed, **ON)), Velocity)
    for pressed, code in ((3, None), (0, None), (3, Code.BUMP)):
        assert getattr(goal.step(at(bumps_and_wheel_drops=pressed)), 'code', None) is code


def test_wheels_that_do_not_follow_stall_in_full_or_off_the_dock():
    goal = undock(FULL)
    orders = [goal.step(at(oi_mode=FULL, **ON)) for _ in range(60)]
    assert any(getattr(order, 'code', None) is Code.STALL for order in orders)
