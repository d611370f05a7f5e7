"""Goals that do not reach their end: each code, what it says, and that the wheels stand then."""

from dataclasses import replace
from math import nan

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Settings
from create_oi_ros.driver.goals import Code, Ending, WallFollow
from create_oi_ros.driver.state import Activity
from create_oi_ros.driver.supervision import SETTLING
from create_oi_ros.sim.body.config import CENTRE
from create_oi_ros.sim.world import shipped
from support.goals import angle, arc, distance, place, pursue, start, until_ended
from support.loop import AT_ONCE, Loop, STEP

FRAME = oi.SLOT


def met(limits: MotionLimits | None = None, **options) -> Loop:
    """Return a robot and a driver that have met, in Safe mode."""
    settings = Settings(limits=limits or MotionLimits())
    loop = Loop(settings, config=CENTRE, **options)
    loop.run(1.0)
    return loop


def moving(loop: Loop, goal=None):
    """Start a goal and wait until the robot moves."""
    running = start(loop, goal or distance(1.0))
    loop.run(1.0)
    assert running.ending is None
    assert any(loop.robot.actuators.wheels)
    return running


def ended(loop: Loop, running, within: float = 2 * FRAME) -> Ending:
    """Return how a goal ended, which must be very soon; the wheels are told to stand then."""
    deadline = loop.now + within
    while running.ending is None:
        assert loop.now <= deadline, 'the goal still runs'
        loop.turn()
    loop.run(2 * STEP)
    assert loop.robot.actuators.wheels == (0, 0)
    assert loop.driver.state.activity is not Activity.GOAL
    return running.ending


# What the robot meets.


@pytest.mark.parametrize(('side', 'where'), [
    ({'bump_left': 1}, 'on the left'), ({'bump_right': 1}, 'on the right'),
    ({'bump_left': 1, 'bump_right': 1}, 'in front')])
@pytest.mark.parametrize('make', [
    lambda: distance(1.0), lambda: angle(300), lambda: arc(90, 0.5), lambda: place(1.0, 0.0)])
def test_a_bump_ends_every_motion(make, side, where):
    loop = met()
    running = moving(loop, make())
    loop.body.force(**side)
    ending = ended(loop, running)
    assert ending.code is Code.BUMP
    assert where in ending.text and 'drive backwards' in ending.text


def test_a_wall_ends_a_distance_where_the_robot_touches_it():
    loop = met(world=shipped('room'))
    ending = pursue(loop, distance(5.0))
    assert ending.code is Code.BUMP
    assert 1.5 < ending.estimate.x < 1.9


def test_a_pressed_bumper_lets_no_distance_begin_but_backwards_and_turns():
    loop = met()
    loop.body.force(bump_left=1)
    loop.run(0.1)
    assert pursue(loop, distance(0.2)).code is Code.BUMP
    assert loop.body.truth().travelled == 0
    assert pursue(loop, place(-0.3, 0.0)).code is Code.BUMP  # it turns, then drives ahead
    assert pursue(loop, angle(20)).code is Code.NONE
    assert pursue(loop, distance(-0.2)).code is Code.NONE


def test_a_bumper_that_is_pressed_again_while_the_robot_backs_off_ends_that():
    loop = met()
    loop.body.force(bump_left=1)
    loop.run(0.1)
    running = moving(loop, distance(-1.0))
    loop.body.unforce()
    loop.run(0.1)
    loop.body.force(bump_right=1)
    assert ended(loop, running).code is Code.BUMP


@pytest.mark.parametrize('mode', [oi.Mode.SAFE, oi.Mode.FULL])
def test_a_cliff_ends_a_motion_and_says_where(mode):
    loop = met()
    loop.driver.set_mode(mode, loop.now)
    loop.run(0.2)
    running = moving(loop)
    loop.body.force(cliff_front_left=1)
    ending = ended(loop, running)
    assert ending.code is Code.CLIFF
    assert 'front left' in ending.text


def test_at_a_cliff_in_full_mode_only_the_way_back_is_open():
    loop = met()
    loop.driver.set_mode(oi.Mode.FULL, loop.now)
    loop.run(0.2)
    loop.body.force(cliff_right=1)
    loop.run(0.1)
    assert pursue(loop, distance(0.1)).code is Code.CLIFF
    assert pursue(loop, angle(30)).code is Code.CLIFF
    assert pursue(loop, distance(-0.1)).code is Code.NONE


def test_safe_mode_itself_may_end_a_way_back_at_a_cliff():
    loop = met()
    loop.body.force(cliff_left=1)
    loop.run(0.1)
    ending = pursue(loop, arc(90, 0.1, direction=-1))
    assert ending.code is Code.CLIFF
    assert 'the robot left SAFE: cliff left' in ending.text


@pytest.mark.parametrize('make', [lambda: distance(1.0), lambda: WallFollow(-1, 60.0, 0.0)])
def test_a_wheel_that_drops_ends_a_motion(make):
    loop = met()
    running = moving(loop, make())
    loop.body.lift(True)
    ending = ended(loop, running)
    assert ending.code is Code.WHEEL_DROP
    assert 'put the robot on the floor' in ending.text


def test_a_robot_in_the_air_begins_nothing():
    loop = met()
    loop.driver.set_mode(oi.Mode.FULL, loop.now)
    loop.run(0.2)
    loop.body.lift(True)
    loop.run(0.1)
    assert pursue(loop, distance(0.1)).code is Code.WHEEL_DROP


def test_held_wheels_stall_by_their_current():
    loop = met()
    running = moving(loop)
    loop.body.hold(right=True, left=True)
    ending = ended(loop, running, within=2.0)
    assert ending.code is Code.STALL
    assert 'current' in ending.text


def test_wheels_that_do_not_follow_stall_even_if_no_current_shows_it():
    loop = met()
    running = moving(loop, distance(5.0))
    loop.body.hold(right=True, left=True)
    loop.body.force(overcurrent_right_wheel=0, overcurrent_left_wheel=0)
    ending = until_ended(loop, running)
    assert ending.code is Code.STALL
    assert 'do not follow' in ending.text
    assert loop.robot.actuators.wheels == (0, 0)


def test_a_robot_that_may_not_turn_its_wheels_says_so():
    for goal in (distance(0.1), angle(10), WallFollow(-1, 5.0, 0.0)):
        ending = pursue(met(MotionLimits(max_wheel_speed=0.0)), goal)
        assert ending.code is Code.STALL
        assert 'max_wheel_speed is 0' in ending.text


# What the robot is.


def test_a_robot_in_passive_says_what_to_do():
    loop = met()
    loop.driver.set_mode(oi.Mode.PASSIVE, loop.now)
    loop.run(0.2)
    ending = pursue(loop, distance(0.1))
    assert ending.code is Code.MODE
    assert 'robot is in PASSIVE' in ending.text and 'set_mode with SAFE' in ending.text


def test_passive_ends_a_motion_that_runs():
    loop = met()
    running = moving(loop)
    loop.driver.set_mode(oi.Mode.PASSIVE, loop.now)
    ending = ended(loop, running, within=0.2)
    assert ending.code is Code.MODE
    assert 'PASSIVE' in ending.text


def test_full_instead_of_safe_changes_nothing():
    loop = met()
    running = moving(loop, distance(0.5))
    loop.driver.set_mode(oi.Mode.FULL, loop.now)
    assert until_ended(loop, running).code is Code.NONE


def test_a_charger_ends_a_motion_with_the_reason():
    loop = met()
    running = moving(loop)
    loop.body.plug_charger(True)
    ending = ended(loop, running)
    assert ending.code is Code.MODE
    assert 'charger' in ending.text
    loop.run(2.0)
    again = pursue(loop, distance(0.1))
    assert again.code is Code.MODE
    assert "pull the charger's plug" in again.text


def test_a_goal_brings_back_the_mode_once_the_hazard_has_gone():
    loop = met()
    running = moving(loop)
    loop.body.force(seconds=0.5, cliff_left=1)
    assert ended(loop, running).code is Code.CLIFF
    assert loop.robot.mode is oi.Mode.PASSIVE
    loop.run(2.0)
    assert pursue(loop, distance(0.1)).code is Code.NONE
    assert loop.robot.mode is oi.Mode.SAFE


def test_a_demo_keeps_goals_away_and_takes_over_from_one():
    loop = met()
    running = moving(loop)
    loop.driver.demos.start(oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    assert running.ending is not None
    assert running.ending.code is Code.SUPERSEDED
    loop.run(0.5)
    ending = pursue(loop, distance(0.1))
    assert ending.code is Code.MODE
    assert 'stop_demo' in ending.text


def test_a_script_keeps_goals_away():
    loop = met()
    loop.driver.scripts.define(oi.Script(script=oi.WaitTime(time=20).encode()))
    loop.driver.scripts.play(loop.now, force=False)
    ending = pursue(loop, distance(0.1))
    assert ending.code is Code.MODE
    assert 'a script plays' in ending.text


def test_while_a_goal_runs_no_script_plays():
    loop = met()
    running = moving(loop)
    loop.driver.scripts.define(oi.Script(script=oi.WaitTime(time=20).encode()))
    assert 'stop it first' in loop.driver.scripts.play(loop.now, force=False).outcome.text
    assert running.ending is None


def test_without_a_robot_a_goal_ends_at_once():
    loop = Loop()
    for _ in range(2):
        ending = pursue(loop, distance(0.1))
        assert ending.code is Code.NO_ROBOT
        assert 'check cable and power' in ending.text
        loop.driver.disconnected('no port')


def test_a_robot_that_no_longer_answers_ends_a_goal():
    loop = met()
    running = moving(loop)
    loop.cut = True
    ending = until_ended(loop, running)
    assert ending.code is Code.LINK


def test_a_port_that_is_lost_ends_a_goal():
    loop = met()
    running = moving(loop)
    loop.driver.disconnected('cable pulled')
    assert running.ending.code is Code.LINK


def test_a_driver_that_ends_ends_its_goal():
    loop = met()
    running = moving(loop)
    loop.driver.shut_down(loop.now)
    assert running.ending.code is Code.LINK
    loop.run(0.1)
    assert loop.robot.actuators.wheels == (0, 0)


# Who else gives orders.


def test_time_that_is_over_ends_a_goal():
    loop = met()
    running = moving(loop, distance(1.0, allowance=1.5))
    ending = ended(loop, running, within=0.6)
    assert ending.code is Code.TIMEOUT
    assert '1.5 s' in ending.text
    assert ending.seconds == pytest.approx(1.5, abs=0.05)


def test_a_goal_of_a_kilometre_has_a_time_and_can_be_canceled():
    loop = met()
    running = moving(loop, distance(1000.0))
    assert 6000 < loop.driver.goals._goal.allowance < 8000
    loop.driver.goals.cancel(running, loop.now)
    assert ended(loop, running).code is Code.CANCELED


@pytest.mark.parametrize('make', [lambda: distance(1.0), lambda: angle(300),
                                  lambda: WallFollow(-1, 60.0, 0.0)])
def test_a_cancel_asks_for_zero_at_once(make):
    loop = met()
    running = moving(loop, make())
    loop.driver.goals.cancel(running, loop.now)
    loop.driver.poll(loop.now)
    assert oi.DriveDirect(right=0, left=0).encode() in loop.driver.data_to_send()
    assert running.ending.code is Code.CANCELED


def test_a_cancel_that_comes_too_late_ends_no_other_goal():
    loop = met()
    first = moving(loop)
    second = moving(loop)
    loop.driver.goals.cancel(first, loop.now)
    loop.driver.goals.abandon(first, loop.now)
    loop.run(0.1)
    assert second.ending is None


def test_a_goal_whose_client_has_gone_is_stopped():
    loop = met()
    running = moving(loop)
    loop.driver.goals.abandon(running, loop.now)
    ending = ended(loop, running)
    assert ending.code is Code.STOPPED
    assert 'client has gone' in ending.text


def test_what_comes_after_the_end_changes_nothing():
    loop = met()
    running = moving(loop)
    loop.driver.goals.cancel(running, loop.now)
    before = running.ending
    loop.driver.goals.abandon(running, loop.now)
    loop.driver.goals.interrupt(loop.now)
    assert running.ending is before


def test_a_robot_that_does_not_enter_its_mode_again_ends_a_goal():
    loop = met()
    loop.run(SETTLING)  # after that, leaving the mode is no late frame
    loop.robot.receive(oi.Start().encode(), loop.now)
    loop.run(2 * FRAME)
    loop.robot.receive = lambda *_: None
    running = start(loop, distance(0.3))
    loop.run(1.2)
    assert running.ending.code is Code.MODE


def test_a_stop_always_wins():
    for interrupt in (True, False):
        loop = met(MotionLimits(commands_interrupt=interrupt))
        running = moving(loop)
        loop.driver.stop(loop.now)
        assert ended(loop, running, within=0.0).code is Code.STOPPED


def test_ten_goals_at_once_leave_one():
    loop = met()
    begun = [start(loop, distance(0.1 + n / 100)) for n in range(10)]
    assert [each.ending.code for each in begun[:-1]] == [Code.SUPERSEDED] * 9
    assert until_ended(loop, begun[-1]).code is Code.NONE
    assert loop.body.truth().travelled == pytest.approx(0.19, abs=0.01)


def test_a_velocity_takes_over_and_drives():
    loop = met()
    running = moving(loop)
    loop.driver.drive(-0.1, 0.0, loop.now)
    assert running.ending.code is Code.SUPERSEDED
    assert loop.driver.state.activity is Activity.DRIVING
    loop.drive(-0.1, 0.0, 1.0)
    assert loop.body.truth().speed == pytest.approx(-0.1, abs=0.01)


def test_a_velocity_of_zero_and_one_that_may_not_interrupt_change_nothing():
    for interrupt, velocity in ((True, (0.0, 0.0)), (False, (0.3, 1.0)), (False, (nan, 0.0))):
        loop = met(MotionLimits(commands_interrupt=interrupt))
        running = start(loop, distance(0.3))
        while running.ending is None:
            loop.driver.drive(*velocity, loop.now)
            loop.run(0.1)
        assert running.ending.code is Code.NONE
        assert loop.body.truth().travelled == pytest.approx(0.3, abs=0.01)


def test_a_velocity_that_is_not_finite_takes_over_and_stops():
    loop = met()
    running = moving(loop)
    loop.driver.drive(nan, 0.0, loop.now)
    assert ended(loop, running, within=0.0).code is Code.SUPERSEDED
    assert any('not finite' in notice.text for notice in loop.notices)


def test_a_goal_takes_over_from_velocities_that_have_ended():
    loop = met()
    loop.drive(0.2, 0.0, 0.3)
    running = start(loop, distance(0.3))
    assert loop.driver.state.activity is Activity.GOAL
    assert until_ended(loop, running).code is Code.NONE


def test_the_odometry_is_not_reset_while_a_goal_needs_it():
    loop = met()
    running = moving(loop)
    answer = loop.driver.reset_odometry().outcome
    assert not answer.ok and 'cancel it first' in answer.text
    loop.driver.goals.cancel(running, loop.now)
    assert loop.driver.reset_odometry().outcome.ok


def test_an_ending_is_told_to_who_asks_before_and_after():
    loop = met()
    running, heard = start(loop, distance(0.05)), []
    running.then(heard.append)
    until_ended(loop, running)
    running.then(heard.append)
    assert [each.code for each in heard] == [Code.NONE] * 2
    running.end(Ending(Code.BUMP, 'too late'))
    assert running.ending.code is Code.NONE


# The bumper holds back commands.


def test_with_bump_stop_no_command_drives_further_into_an_obstacle():
    loop = met(replace(AT_ONCE, bump_stop=True))
    loop.drive(0.2, 0.0, 0.5)
    loop.body.force(bump_left=1)
    loop.drive(0.2, 0.5, 0.3)
    right, left = loop.robot.actuators.wheels
    assert right == -left > 0, 'it may turn away'
    loop.drive(-0.1, 0.0, 0.3)
    assert loop.robot.actuators.wheels == (-100, -100)
    loop.drive(-0.1, 0.5, 0.3)
    right, left = loop.robot.actuators.wheels
    assert right + left == pytest.approx(-200, abs=2)
    loop.body.unforce()
    loop.drive(0.2, 0.0, 0.3)
    assert loop.robot.actuators.wheels == (200, 200)


def test_without_bump_stop_the_bumper_holds_nothing_back():
    loop = met()
    loop.body.force(bump_left=1)
    loop.drive(0.2, 0.0, 0.5)
    assert loop.robot.actuators.wheels == (200, 200)
