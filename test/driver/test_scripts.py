# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Scripts that services define and play, and where the robot is after them."""

from functools import cache
from math import cos, degrees, hypot, sin, sqrt
from statistics import fmean

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, Outcome, Settings, Severity
from create_oi_ros.driver.listening import QUESTIONS
from create_oi_ros.oi.script import build_script
from create_oi_ros.oi.tools.text import parse_script
from create_oi_ros.robot import Rounding, WHEEL_SEPARATION
from create_oi_ros.sim.firmware.guesses import Guesses
from support.asking import ask, in_mode, power_cycle
from support.loop import AT_ONCE, Loop, texts

LEDS = oi.Leds(bits=oi.LedBits.PLAY | oi.LedBits.ADVANCE, color=10, intensity=200)
WAITING = parse_script('Drive velocity=200 radius=straight; Wait Time time=20')
ENDLESS = parse_script('Wait Time time=1; Play Script')


def have_played(loop: Loop, script: oi.Script, force=False, seconds=0.2) -> Outcome:
    """Define a script and have it played; return what is said of that after some time."""
    ask(loop, loop.driver.scripts.define, script)
    return ask(loop, loop.driver.scripts.play, loop.now, force=force, seconds=seconds)


def test_while_the_robot_drives_no_script_is_played(loop):
    ask(loop, loop.driver.scripts.define, WAITING)
    loop.driver.drive(0.2, 0.0, loop.now)
    answer = loop.driver.scripts.play(loop.now, force=True).outcome
    assert answer.ok is False
    assert 'stop it first' in answer.text


def test_a_script_plays_and_the_wheels_stand_when_it_has_ended(loop):
    defined = ask(loop, loop.driver.scripts.define, WAITING)
    assert defined.ok
    assert '7 of 100 bytes' in defined.text
    assert ask(loop, loop.driver.scripts.play, loop.now, force=False).ok
    loop.run(1.0)
    assert loop.driver.scripts.playing
    assert loop.body.truth().speed > 0.1
    loop.run(2.0)
    assert loop.driver.state.activity is Activity.IDLE
    assert loop.body.truth().speed == 0
    loop.drive(0.2, 0.0, 1.5)
    assert loop.body.truth().speed > 0.1
    assert loop.estimate.x == pytest.approx(loop.body.truth().pose.x, abs=0.01)


def begun_by_a_request(loop: Loop) -> None:
    loop.driver.modes.start_demo(oi.DemoNumber.DRIVE_FIGURE_EIGHT)


def begun_by_a_button(loop: Loop) -> None:
    in_mode(loop, oi.Mode.PASSIVE)
    loop.robot.receive(oi.Demo(demo=oi.DemoNumber.DRIVE_FIGURE_EIGHT).encode(), loop.now)


def begun_by_a_button_after_a_hazard(loop: Loop) -> None:
    loop.body.force(seconds=0.5, drop_left=1)
    loop.run(1.0)
    loop.robot.receive(oi.Demo(demo=oi.DemoNumber.DRIVE_FIGURE_EIGHT).encode(), loop.now)


@pytest.mark.parametrize('begin', [
    begun_by_a_request, begun_by_a_button, begun_by_a_button_after_a_hazard])
def test_a_script_ends_a_demo_that_runs(loop, begin):
    ask(loop, loop.driver.scripts.define, WAITING)
    begin(loop)
    loop.run(1.0)
    assert loop.robot.demo is oi.DemoNumber.DRIVE_FIGURE_EIGHT
    assert ask(loop, loop.driver.scripts.play, loop.now, force=False).ok
    loop.run(3.0)
    assert 'the script has ended; wheels stopped' in texts(loop.notices, Severity.INFO)
    assert loop.robot.demo is None and loop.robot.actuators.wheels == (0, 0)


def test_a_script_at_once_after_its_mode_was_set_plays_in_it(loop):
    ask(loop, loop.driver.scripts.define, WAITING)
    in_mode(loop, oi.Mode.PASSIVE)
    loop.driver.modes.set(oi.Mode.SAFE, loop.now)
    assert ask(loop, loop.driver.scripts.play, loop.now, force=False).ok
    assert (loop.robot.mode, loop.robot.waiting) == (oi.Mode.SAFE, True)


def test_after_a_script_that_leaves_safe_commands_must_pause(loop):
    loop.run(3.0)
    have_played(loop, parse_script('Start; Wait Time time=10'))
    loop.drive(0.2, 0.0, 4.0)
    assert not loop.driver.scripts.playing
    assert (loop.robot.mode, loop.robot.actuators.wheels) == (oi.Mode.PASSIVE, (0, 0))
    loop.run(1.0)
    loop.drive(0.2, 0.0, 0.5)
    assert loop.robot.actuators.wheels == (200, 200)


def test_an_answer_that_comes_without_a_port_ends_no_script(loop):
    have_played(loop, WAITING)
    loop.run(0.3)
    loop.driver.disconnected('the cable was pulled')
    loop.run(3.0)
    assert loop.driver.state.activity is Activity.CLOSED
    assert not any('script has ended' in text for text in texts(loop.notices, Severity.INFO))


def test_a_script_that_enters_full_is_sent_no_end_of_a_demo(loop):
    loop.run(3.0)
    have_played(loop, parse_script('Full; Wait Time time=10'))
    loop.drive(0.2, 0.0, 4.0)
    assert (loop.robot.mode, loop.robot.actuators.wheels) == (oi.Mode.SAFE, (200, 200))


def test_while_a_script_plays_nothing_is_promised_and_what_stops_it_is_said(loop):
    have_played(loop, WAITING, seconds=1.0)
    stopped = loop.driver.stop(loop.now).outcome
    assert not stopped.ok
    for words in ('a script plays', 'for about 1 s more', 'Power button'):
        assert words in stopped.text
    assert loop.driver.health(loop.now).busy == stopped.text
    for answer in (ask(loop, loop.driver.outputs.set_leds, LEDS),
                   ask(loop, loop.driver.modes.set, oi.Mode.PASSIVE, loop.now)):
        assert answer.ok is False
        assert 'script' in answer.text
    loop.drive(0.2, 0.0, 0.2)
    assert 'script' in [notice.text for notice in loop.notices][-1]


def test_a_script_that_cannot_end_is_refused_unless_forced(loop):
    assert 'may never end' in ask(loop, loop.driver.scripts.define, ENDLESS).text
    loop.robot.guesses = Guesses(loop_listens=False)
    refused = ask(loop, loop.driver.scripts.play, loop.now, force=False)
    assert not refused.ok
    assert 'force' in refused.text
    assert ask(loop, loop.driver.scripts.play, loop.now, force=True).ok
    loop.run(5.0)
    assert loop.driver.scripts.playing
    power_cycle(loop)
    assert not loop.driver.scripts.playing
    assert loop.robot.mode is oi.Mode.SAFE


def test_a_robot_that_obeys_between_the_rounds_of_its_script_is_driven_again(loop):
    assert have_played(loop, parse_script('Send IR byte=5; Play Script'), force=True).ok
    loop.run(0.5)
    assert 'may go on' in loop.notices[-1].text
    loop.drive(0.2, 0.0, 0.5)
    assert loop.body.truth().speed > 0.1
    assert ask(loop, loop.driver.scripts.define, oi.Script(script=b'')).ok
    assert loop.robot.actuators.infrared_sent
    loop.robot.actuators.infrared_sent.clear()
    loop.run(0.5)
    assert not loop.robot.actuators.infrared_sent


@pytest.mark.parametrize('guesses', [
    {'wait_queue': 0}, {'wait_queue': 135}, {'wait_queue': 135, 'wait_answers': True}], ids=str)
def test_a_robot_that_waits_is_sent_next_to_nothing_and_stands_after_it(loop, guesses):
    loop.robot.guesses = Guesses(**guesses)
    have_played(loop, parse_script('Drive velocity=200 radius=straight; Wait Time time=250'))
    loop.run(0.1)
    loop.heard.clear()
    loop.driver.stop(loop.now)
    loop.run(0.02)
    assert bytes(loop.heard) == oi.DriveDirect(right=0, left=0).encode()
    for _ in range(23):
        loop.driver.stop(loop.now)
        loop.drive(0.2, 0.0, 1.0)
    assert loop.robot.waiting
    assert len(loop.heard) < 100
    loop.run(4.0)
    assert not loop.robot.waiting
    assert not loop.driver.scripts.playing
    assert loop.body.truth().speed == 0
    assert loop.driver.counts.silences == 0
    assert loop.robot.mode is oi.Mode.SAFE
    loop.drive(0.2, 0.0, 0.5)
    assert loop.body.truth().speed > 0.1


def test_a_script_whose_own_motion_leads_away_from_what_it_waits_for_needs_force(loop):
    refused = have_played(loop, parse_script(
        'Drive velocity=200 radius=straight; Wait Distance distance=-1000'))
    assert not refused.ok
    assert 'command 2 of the stored script, Wait Distance distance=-1000, waits' in refused.text
    assert 'the robot drives forwards' in refused.text
    loop.run(1.0)
    assert loop.body.truth().speed == 0
    assert ask(loop, loop.driver.scripts.play, loop.now, force=True).ok


def test_a_script_that_is_not_known_needs_force(loop):
    loop.robot.script = WAITING.script
    refused = ask(loop, loop.driver.scripts.play, loop.now, force=False)
    assert not refused.ok and 'call define_script, or set force' in refused.text
    assert ask(loop, loop.driver.scripts.play, loop.now, force=True).ok


def test_a_robot_that_falls_silent_while_it_waits_is_found_again(loop):
    loop.robot.guesses = Guesses(stream_while_waiting=False)
    have_played(loop, WAITING)
    loop.run(4.0)
    assert loop.driver.state.answered
    assert not loop.driver.scripts.playing
    assert loop.body.truth().speed == 0


@pytest.mark.parametrize('delay', [0.005, 0.02, 0.05])
def test_a_late_frame_of_a_script_before_does_not_end_the_next_one(loop, delay):
    loop.delay = delay
    script = build_script([
        *(oi.Stream(packets=each.ids) for each in loop.driver.plan.questions[:-1]),
        oi.WaitTime(time=20)])
    for _ in range(2):
        loop.driver.scripts.define(script)
        loop.driver.scripts.play(loop.now, force=False)
        begun = loop.now
        while loop.driver.scripts.playing:
            loop.turn()
        assert 2.0 <= loop.now - begun < 2.5


@pytest.mark.parametrize('packets', [*QUESTIONS, *Loop().driver.plan.questions], ids=str)
def test_a_script_that_streams_the_list_of_a_question_is_not_taken_for_silence(loop, packets):
    asks = oi.Stream(packets=packets.ids)
    have_played(loop, build_script([asks, oi.WaitTime(time=20)]))
    loop.run(1.5)
    assert loop.driver.scripts.playing
    loop.run(1.5)
    assert not loop.driver.scripts.playing
    assert loop.driver.counts.silences == 0


@pytest.mark.parametrize('force', [False, True])
def test_a_script_whose_end_no_list_could_show_is_refused(loop, force):
    lists = loop.driver.plan.questions
    streams = [oi.Stream(packets=each.ids) for each in lists]
    ask(loop, loop.driver.scripts.define, build_script(streams))
    refused = ask(loop, loop.driver.scripts.play, loop.now, force=force)
    assert not refused.ok and 'in one of them' in refused.text
    ask(loop, loop.driver.scripts.define, build_script(streams[1:]))
    for _ in lists:
        assert ask(loop, loop.driver.scripts.play, loop.now, force=force, seconds=2.0).ok
        assert not loop.driver.scripts.playing


@pytest.mark.parametrize('queue', [0, 256])
@pytest.mark.parametrize('delay', [0.0, 0.008, 0.016, 0.04])
def test_a_script_that_is_played_again_as_soon_as_it_has_ended_is_followed_to_its_end(
        delay, queue):
    loop = Loop(delay=delay)
    loop.robot.guesses = Guesses(wait_queue=queue)
    loop.run(3.0)
    ask(loop, loop.driver.scripts.define, parse_script(
        'Drive velocity=150 radius=straight; Wait Time time=12; Drive velocity=0 radius=straight'))
    for _ in range(3):
        played, begun = loop.driver.scripts.play(loop.now, force=False), loop.now
        while loop.driver.scripts.playing:
            loop.turn()
        assert played.outcome.ok
        assert loop.now - begun > 1.19, 'it is said to be over while it plays'
        assert loop.robot.actuators.wheels == (0, 0) and not loop.robot.waiting
    loop.drive(0.2, 0.0, 0.5)
    assert loop.body.truth().speed == pytest.approx(0.2, abs=0.01)
    assert not texts(loop.notices, Severity.ERROR)


# Where the robot is after a script, during which nobody can ask it.


LINE = 'Drive velocity=200 radius=straight; Wait Time time=20'
ARC = 'Drive velocity=-150 radius=500; Wait Time time=40; Drive velocity=0 radius=straight'
CORNER = ('Drive velocity=300 radius=straight; Wait Distance distance=400; '
          'Drive velocity=100 radius=in_place_clockwise; Wait Angle angle=-90; '
          'Drive velocity=300 radius=straight; Wait Distance distance=400')
DIRECT = ('Drive Direct right=200 left=100; Wait Time time=20; Drive Direct right=-100 left=150; '
          'Wait Time time=30')
MIXED = ('Drive Direct right=200 left=100; Wait Time time=20; '
         'Drive velocity=-100 radius=straight; Wait Time time=30')
LESSON = ((239, 161), (10, 190), (0, 0), (-174, -226), (352, 248), (64, -64), (0, 0))
"""Speeds of the right and the left wheel, mm/s."""


@cache
def lessons(rounding: Rounding, begin: int) -> Loop:
    """Return a driver after half a minute of driving by steps, as scripts drive."""
    loop = Loop(Settings(odometry_window=1.0, limits=AT_ONCE), rounding=rounding)
    loop.run(0.3)
    for right, left in (LESSON[begin:] + LESSON[:begin]) * 3:
        loop.drive((right + left) / 2000, (right - left) / 1000 / WHEEL_SEPARATION, 1.5)
    return loop


def learned(rounding: Rounding, begin: int = 0) -> Loop:
    """Return a driver that knows its robot. Tests share it: each one plays and comes to rest."""
    loop = lessons(rounding, begin)
    loop.run(1.0)
    # Readings still correct where the lessons ended; with a new origin they correct the script.
    loop.driver.reset_odometry()
    loop.run(0.1)
    return loop


def seen_from(yaw: float, x: float, y: float) -> tuple[float, float]:
    """Return a way as somebody sees it who looks in that direction."""
    return x * cos(yaw) + y * sin(yaw), y * cos(yaw) - x * sin(yaw)


def play(loop: Loop, text: str) -> tuple[float, float, float]:
    """Play a script to its end; return what it missed, m and degrees, and its doubt, m."""
    before, started = loop.estimate, loop.body.truth()
    defined = loop.driver.scripts.define(parse_script(text))
    loop.run(0.2)
    played = loop.driver.scripts.play(loop.now, force=False)
    while loop.driver.scripts.playing or played.outcome is None:
        loop.run(0.1)
    loop.run(3.0)
    assert defined.outcome.ok and played.outcome.ok
    after, ended = loop.estimate, loop.body.truth()
    assert abs(ended.travelled - started.travelled) + abs(ended.turned - started.turned) > 0.1
    told = seen_from(before.yaw, after.x - before.x, after.y - before.y)
    true = seen_from(started.turned, ended.pose.x - started.pose.x, ended.pose.y - started.pose.y)
    return (hypot(told[0] - true[0], told[1] - true[1]),
            abs(degrees(after.yaw - before.yaw - ended.turned + started.turned)),
            sqrt(after.pose_covariance[0] + after.pose_covariance[4]))


@pytest.mark.parametrize(('script', 'metres', 'turn'), [
    (LINE, 0.008, 1.0), (ARC, 0.008, 1.0), (CORNER, 0.015, 2.0), (DIRECT, 0.008, 1.0)])
@pytest.mark.parametrize('rounding', list(Rounding))
def test_after_a_script_the_odometry_is_where_the_robot_is(
        rounding: Rounding, script: str, metres: float, turn: float) -> None:
    """
    As a root mean square of drivers that learned in another order: one alone may be lucky.

    A wheel that reverses is counted backwards while it brakes, so it must be known how it brakes.
    """
    played = [play(learned(rounding, begin), script) for begin in range(0, len(LESSON), 2)]
    places, headings, _ = zip(*played)
    assert sqrt(fmean(each ** 2 for each in places)) < metres
    assert sqrt(fmean(each ** 2 for each in headings)) < turn


def test_a_script_is_followed_again_when_it_is_played_again() -> None:
    """The echo of its first command is there already."""
    loop = learned(Rounding.TRUNCATE)
    for _ in range(2):
        assert play(loop, LINE)[0] < 0.012


def test_a_script_that_cannot_be_followed_leaves_doubt() -> None:
    place, _, doubt = play(learned(Rounding.TRUNCATE), MIXED)
    assert place < 2 * doubt


def test_while_a_script_plays_distance_and_angle_are_not_read() -> None:
    """A robot that waits cannot be asked for another list."""
    loop = learned(Rounding.TRUNCATE)
    loop.commands()
    play(loop, LINE)
    commands = loop.commands()
    played = commands.index(oi.PlayScript())
    asked = [each for each in commands[:played] if isinstance(each, oi.Stream)][-1]
    assert asked.packets == loop.driver.plan.script.ids
    assert not {19, 20} & set(asked.packets)


def test_a_script_that_is_refused_leaves_the_stream_as_it_is(loop: Loop) -> None:
    assert loop.driver.scripts.play(loop.now, force=False).outcome.ok is False
    loop.run(0.1)
    assert not any(isinstance(each, oi.Drive) for each in loop.commands())


def test_a_speed_that_the_robot_reports_oddly_is_not_known(loop: Loop) -> None:
    scripts = loop.driver.scripts
    scripts.define(parse_script(LINE))
    scripts.play(loop.now, force=False)
    for velocity, speeds in ((200, (0.2, 0.2)), (None, None)):
        readings = oi.Readings({'requested_velocity': velocity, 'requested_radius': -32768})
        assert scripts.speeds(readings) == speeds
