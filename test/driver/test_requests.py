"""What services ask of the driver, played against the simulated robot without a clock."""

from math import nan

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Driver, Link, Settings
from create_oi_ros.oi.script import build_script
from create_oi_ros.oi.tools.text import parse_script
from create_oi_ros.sim.firmware.guesses import Guesses
from support.loop import Loop

BLUE = oi.LedBits.PLAY | oi.LedBits.ADVANCE
HIGH = oi.OutputBits.OUTPUT_0 | oi.OutputBits.OUTPUT_2
WAITING = parse_script('Drive velocity=200 radius=straight; Wait Time time=20')
ENDLESS = parse_script('Wait Time time=1; Play Script')


@pytest.fixture
def loop() -> Loop:
    """Return a robot and a driver that have met."""
    met = Loop()
    met.run(0.3)
    met.commands()
    return met


class Answer:
    """Takes the reply to one request."""

    def __init__(self) -> None:
        self.success: bool | None = None
        self.message = ''
        self.script = b''

    def __call__(self, success: bool, message: str, script: bytes = b'') -> None:
        """Be told; once only."""
        assert self.success is None, 'answered twice'
        self.success, self.message, self.script = success, message, script


def ask(loop: Loop, request, *arguments, seconds: float = 0.2, **named) -> Answer:
    """Make a request and let time pass; it must have been answered then."""
    answer = Answer()
    request(*arguments, **named, reply=answer)
    loop.run(seconds)
    assert answer.success is not None
    return answer


def in_mode(loop: Loop, mode: oi.Mode) -> None:
    """Have the robot in a mode."""
    assert ask(loop, loop.driver.set_mode, mode, loop.now).success


def power_cycle(loop: Loop) -> None:
    """Switch the robot off and on, and let the driver find it again."""
    loop.robot.power(False, loop.now)
    loop.run(1.0)
    loop.robot.power(True, loop.now)
    loop.run(6.0)
    assert loop.driver.link is Link.UP


# Actuators.


def test_leds_shine(loop):
    assert ask(loop, loop.driver.actuators.set_leds, BLUE, 10, 200).success
    assert loop.robot.lights == (BLUE, 10, 200)


def test_outputs_and_drivers_are_set(loop):
    assert ask(loop, loop.driver.actuators.set_outputs, HIGH).success
    assert loop.robot.outputs == HIGH
    assert ask(loop, loop.driver.actuators.set_drivers, (0.0, 0.5, 1.0)).success
    assert tuple(loop.robot.actuators.duties) == (0, 64, 128)


@pytest.mark.parametrize('duty', [-0.1, 1.01, nan])
def test_a_duty_cycle_out_of_range_is_refused(loop, duty):
    answer = ask(loop, loop.driver.actuators.set_drivers, (0.0, 0.0, duty))
    assert not answer.success
    assert 'driver_2' in answer.message
    assert loop.commands() == []


def test_an_infrared_character_is_sent(loop):
    assert ask(loop, loop.driver.actuators.send_ir, 137).success
    assert list(loop.robot.actuators.infrared_sent) == [137]


def test_a_song_is_stored_and_plays(loop):
    defined = ask(loop, loop.driver.actuators.define_song, 3, [60, 0, 72], [0.5, 0.25, 0.5])
    assert defined.success
    assert '1.250 s' in defined.message
    assert loop.robot.speaker.songs[3] == ((60, 32), (0, 16), (72, 32))
    assert ask(loop, loop.driver.actuators.play_song, 3).success
    assert loop.moved[-1].readings.song_playing
    again = ask(loop, loop.driver.actuators.play_song, 3)
    assert not again.success
    assert 'a song plays' in again.message


def test_rounding_is_told(loop):
    answer = ask(loop, loop.driver.actuators.define_song, 0, [60, 60], [0.1, 0.001])
    assert answer.success
    assert 'rounded to 1/64 s' in answer.message
    assert '1 so short' in answer.message


@pytest.mark.parametrize(('number', 'pitches', 'seconds', 'named'), [
    (16, [60], [0.5], 'number'), (0, [60, 61], [0.5], 'durations'), (0, [60], [4.1], 'seconds[0]'),
    (0, [60], [-0.1], 'seconds[0]'), (0, [60], [nan], 'seconds[0]'), (0, [], [], '16 notes'),
    (0, [60] * 17, [0.1] * 17, '16 notes'), (0, [256], [0.1], 'notes[0]'),
])
def test_a_wrong_song_is_refused_before_a_byte_leaves(loop, number, pitches, seconds, named):
    answer = ask(loop, loop.driver.actuators.define_song, number, pitches, seconds)
    assert not answer.success
    assert named in answer.message
    assert loop.commands() == []


def test_define_and_play_stores_nothing_that_cannot_be_played(loop):
    in_mode(loop, oi.Mode.PASSIVE)
    answer = ask(loop, loop.driver.actuators.define_and_play, 0, [60], [0.5])
    assert not answer.success
    assert 'set_mode' in answer.message
    assert not loop.robot.speaker.songs
    in_mode(loop, oi.Mode.SAFE)
    assert ask(loop, loop.driver.actuators.define_and_play, 0, [60], [0.5]).success
    assert loop.moved[-1].readings.song_playing


def test_a_song_that_was_not_defined_is_refused(loop):
    assert 'define_song' in ask(loop, loop.driver.actuators.play_song, 7).message


@pytest.mark.parametrize('request_of', [
    lambda driver, reply: driver.actuators.set_leds(BLUE, 0, 0, reply),
    lambda driver, reply: driver.actuators.set_outputs(HIGH, reply),
    lambda driver, reply: driver.actuators.set_drivers((0, 0, 1), reply),
    lambda driver, reply: driver.actuators.send_ir(1, reply),
])
def test_in_passive_the_reply_says_what_to_do(loop, request_of):
    in_mode(loop, oi.Mode.PASSIVE)
    loop.commands()
    answer = Answer()
    request_of(loop.driver, answer)
    assert answer.success is False
    assert answer.message == 'robot is in PASSIVE: call set_mode with SAFE first'
    assert loop.commands() == []


@pytest.mark.parametrize('request_of', [
    lambda driver, reply: driver.actuators.define_song(0, [60], [0.5], reply),
    lambda driver, reply: driver.actuators.set_leds(BLUE, 0, 0, reply),
    lambda driver, reply: driver.demos.start(oi.DemoNumber.COVER, reply),
    lambda driver, reply: driver.demos.stop(reply),
    lambda driver, reply: driver.scripts.define(WAITING, reply),
    lambda driver, reply: driver.scripts.play(0.0, reply, force=True),
    lambda driver, reply: driver.scripts.show(0.0, reply),
])
def test_without_a_robot_every_request_is_refused_at_once(request_of):
    answer = Answer()
    request_of(Driver(), answer)
    assert answer.success is False
    assert 'port' in answer.message


def test_a_request_whose_robot_is_lost_is_answered(loop):
    answer = Answer()
    loop.driver.actuators.define_song(0, [60], [0.5], answer)
    loop.driver.disconnected('gone')
    assert answer.success is False
    assert 'lost' in answer.message


# Restoring.


def set_everything(loop: Loop) -> None:
    """Set all that is restored, and a low side driver, which is not."""
    assert ask(loop, loop.driver.actuators.set_leds, BLUE, 10, 200).success
    assert ask(loop, loop.driver.actuators.set_outputs, HIGH).success
    assert ask(loop, loop.driver.actuators.set_drivers, (1.0, 0.0, 0.0)).success
    assert ask(loop, loop.driver.actuators.define_song, 3, [60], [0.5]).success


def assert_restored(loop: Loop) -> None:
    """See all of it at the robot."""
    assert loop.robot.mode in oi.ACTUATE
    assert loop.robot.lights == (BLUE, 10, 200)
    assert loop.robot.outputs == HIGH
    assert loop.robot.speaker.songs[3] == ((60, 32),)


@pytest.mark.parametrize(('before', 'after'), [
    (oi.Mode.SAFE, oi.Mode.SAFE), (oi.Mode.PASSIVE, oi.Mode.SAFE), (oi.Mode.FULL, oi.Mode.SAFE),
    (oi.Mode.PASSIVE, oi.Mode.FULL),
])
def test_leds_and_outputs_are_restored_after_a_mode_change(loop, before, after):
    set_everything(loop)
    in_mode(loop, before)
    in_mode(loop, after)
    loop.run(0.1)
    assert_restored(loop)


def test_all_is_restored_after_a_power_cycle_but_drivers_stay_off(loop):
    set_everything(loop)
    power_cycle(loop)
    assert_restored(loop)
    assert tuple(loop.robot.actuators.duties) == (0, 0, 0)


def test_all_is_restored_after_a_reconnect(loop):
    set_everything(loop)
    loop.cut = True
    loop.run(2.0)
    loop.cut = False
    loop.run(2.0)
    assert_restored(loop)


def test_all_is_restored_after_a_drop(loop):
    set_everything(loop)
    loop.body.drop(left=True)
    loop.run(0.3)
    loop.body.drop()
    loop.run(2.0)
    loop.drive(0.1, 0.0, 0.5)
    assert_restored(loop)


@pytest.mark.parametrize('mode', [oi.Mode.PASSIVE, oi.Mode.FULL])
def test_nothing_moves_when_the_driver_has_said_goodbye(mode):
    loop = Loop(Settings(mode_on_start=oi.Mode.FULL, mode_on_exit=mode))
    loop.run(0.3)
    ask(loop, loop.driver.actuators.set_drivers, (1.0, 1.0, 1.0))
    loop.drive(0.2, 0.0, 0.3)
    loop.driver.shut_down(loop.now)
    loop.turn()
    assert tuple(loop.robot.actuators.duties) == (0, 0, 0)
    assert loop.robot.mode is mode
    loop.run(1.0)
    assert loop.body.truth().speed == 0


# Demos.


def test_a_demo_ends_when_the_driver_does(loop):
    ask(loop, loop.driver.demos.start, oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    loop.driver.shut_down(loop.now)
    loop.turn()
    assert loop.robot.demo is None


def test_a_demo_runs_until_it_is_stopped(loop):
    answer = ask(loop, loop.driver.demos.start, oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    assert answer.success
    assert loop.robot.demo is oi.DemoNumber.DRIVE_FIGURE_EIGHT
    assert loop.driver.status.wanted is oi.Mode.PASSIVE
    assert loop.driver.status.reason == ''
    assert ask(loop, loop.driver.demos.stop).success
    assert loop.robot.demo is None
    assert loop.body.truth().speed == pytest.approx(0, abs=0.2)


def test_stop_ends_a_demo_too(loop):
    ask(loop, loop.driver.demos.start, oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    assert loop.driver.stop(loop.now)[0]
    loop.run(0.5)
    assert loop.robot.demo is None
    assert loop.body.truth().speed == 0


def test_stopping_no_demo_leaves_the_mode(loop):
    assert ask(loop, loop.driver.demos.stop).success
    assert loop.robot.mode is oi.Mode.SAFE


def test_before_docking_the_robot_rests_a_second_in_passive(loop):
    answer = Answer()
    loop.driver.demos.start(oi.DemoNumber.COVER_AND_DOCK, answer)
    loop.run(0.9)
    assert answer.success is None
    assert loop.robot.mode is oi.Mode.PASSIVE
    loop.run(0.3)
    assert answer.success
    assert loop.robot.demo is oi.DemoNumber.COVER_AND_DOCK


def test_stop_ends_a_demo_that_is_about_to_begin(loop):
    loop.driver.demos.start(oi.DemoNumber.COVER_AND_DOCK, Answer())
    loop.run(0.5)
    assert loop.driver.stop(loop.now)[0]
    loop.run(1.0)
    assert loop.robot.demo is None
    assert loop.body.truth().speed == 0


# Scripts.


def test_while_the_robot_drives_no_script_is_played_or_shown(loop):
    ask(loop, loop.driver.scripts.define, WAITING)
    loop.driver.drive(0.2, 0.0, loop.now)
    played, shown = Answer(), Answer()
    loop.driver.scripts.play(loop.now, played, force=True)
    loop.driver.scripts.show(loop.now, shown)
    for answer in (played, shown):
        assert answer.success is False
        assert 'stop it first' in answer.message


def test_a_script_plays_and_the_wheels_stand_when_it_has_ended(loop):
    defined = ask(loop, loop.driver.scripts.define, WAITING)
    assert defined.success
    assert '7 of 100 bytes' in defined.message
    assert ask(loop, loop.driver.scripts.play, loop.now, force=False).success
    loop.run(1.0)
    assert loop.driver.scripts.playing
    assert loop.body.truth().speed > 0.1
    loop.run(2.0)
    assert not loop.driver.scripts.playing
    assert loop.body.truth().speed == 0
    loop.drive(0.2, 0.0, 0.5)
    assert loop.body.truth().speed > 0.1
    assert loop.estimate.x == pytest.approx(loop.body.truth().pose.x, abs=0.003)


def test_while_a_script_plays_nothing_is_promised(loop):
    ask(loop, loop.driver.scripts.define, WAITING)
    ask(loop, loop.driver.scripts.play, loop.now, force=False)
    for answer in (ask(loop, loop.driver.actuators.set_leds, BLUE, 0, 0),
                   ask(loop, loop.driver.set_mode, oi.Mode.PASSIVE, loop.now)):
        assert answer.success is False
        assert 'script' in answer.message
    success, message = loop.driver.stop(loop.now)
    assert not success
    assert 'script' in message
    loop.drive(0.2, 0.0, 0.5)
    assert 'script' in [notice.text for notice in loop.notices][-1]


def test_leds_are_restored_after_a_script_that_enters_safe(loop):
    ask(loop, loop.driver.actuators.set_leds, BLUE, 10, 200)
    ask(loop, loop.driver.scripts.define, parse_script('Safe; Wait Time time=2'))
    ask(loop, loop.driver.scripts.play, loop.now, force=False, seconds=1.0)
    assert loop.robot.lights == (BLUE, 10, 200)


def test_a_script_that_cannot_end_is_refused_unless_forced(loop):
    assert 'cannot end' in ask(loop, loop.driver.scripts.define, ENDLESS).message
    refused = ask(loop, loop.driver.scripts.play, loop.now, force=False)
    assert not refused.success
    assert 'force' in refused.message
    assert ask(loop, loop.driver.scripts.play, loop.now, force=True).success
    loop.run(5.0)
    assert loop.driver.scripts.playing
    power_cycle(loop)
    assert not loop.driver.scripts.playing
    assert loop.robot.mode is oi.Mode.SAFE


def test_a_script_whose_end_is_open_says_so(loop):
    script = parse_script('Wait Event event=bump; Wait Distance distance=100')
    message = ask(loop, loop.driver.scripts.define, script).message
    assert 'Wait Event event=bump, Wait Distance distance=100' in message


def test_a_script_that_is_not_known_is_refused_until_it_is_shown(loop):
    loop.robot.script = WAITING.script
    assert not ask(loop, loop.driver.scripts.play, loop.now, force=False).success
    assert ask(loop, loop.driver.scripts.show, loop.now, seconds=0.5).script == WAITING.script
    assert ask(loop, loop.driver.scripts.play, loop.now, force=False).success


def test_an_empty_script_is_refused(loop):
    ask(loop, loop.driver.scripts.define, oi.Script(script=b''))
    assert 'no script' in ask(loop, loop.driver.scripts.play, loop.now, force=True).message


def test_bytes_that_are_no_whole_commands_are_no_script(loop):
    for code in (b'\x91\x00', b'\x05'):
        assert not ask(loop, loop.driver.scripts.define, oi.Script(script=code)).success
    assert loop.robot.script == b''


@pytest.mark.parametrize('length', [0, 1, 50, 100])
@pytest.mark.parametrize('delay', [0.0, 0.03])
def test_the_stored_script_is_read_back_and_the_stream_goes_on(length, delay):
    loop = Loop(delay=delay)
    loop.run(0.5)
    script = build_script([oi.Safe()] * length)
    ask(loop, loop.driver.scripts.define, script)
    shown = ask(loop, loop.driver.scripts.show, loop.now, seconds=0.6)
    assert (shown.success, shown.script) == (True, script.script)
    frames = loop.driver.counts.frames
    loop.run(1.0)
    assert loop.driver.counts.frames - frames > 60
    assert loop.driver.counts.silences == 0


def test_a_script_that_does_not_come_is_given_up(loop):
    answer = Answer()
    loop.driver.scripts.show(loop.now, answer)
    loop.run(0.05)
    loop.cut = True
    loop.run(1.0)
    assert answer.success is False
    loop.cut = False
    loop.run(2.0)
    assert loop.driver.link is Link.UP


def test_a_robot_that_falls_silent_while_it_waits_is_found_again():
    loop = Loop()
    loop.robot.guesses = Guesses(stream_while_waiting=False)
    loop.run(0.3)
    ask(loop, loop.driver.scripts.define, WAITING)
    ask(loop, loop.driver.scripts.play, loop.now, force=False)
    loop.run(4.0)
    assert loop.driver.link is Link.UP
    assert not loop.driver.scripts.playing
    assert loop.body.truth().speed == 0
