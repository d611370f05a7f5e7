"""What services ask of the driver, played against the simulated robot without a clock."""

from math import nan

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, Driver, Outcome, Pending, Settings, Severity
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


def ask(loop: Loop, request, *arguments, seconds: float = 0.2, **named) -> Outcome:
    """Make a request, let time pass, and return the outcome, which must be known then."""
    pending = request(*arguments, **named)
    loop.run(seconds)
    assert pending.outcome is not None
    return pending.outcome


def in_mode(loop: Loop, mode: oi.Mode) -> None:
    """Have the robot in a mode."""
    assert ask(loop, loop.driver.set_mode, mode, loop.now).ok


def power_cycle(loop: Loop) -> None:
    """Switch the robot off and on, and let the driver find it again."""
    loop.robot.power(False, loop.now)
    loop.run(1.0)
    loop.robot.power(True, loop.now)
    loop.run(6.0)
    assert loop.driver.state.answered


# Actuators.


def test_leds_shine(loop):
    assert ask(loop, loop.driver.outputs.set_leds, BLUE, 10, 200).ok
    assert loop.robot.lights == (BLUE, 10, 200)


def test_outputs_and_drivers_are_set(loop):
    assert ask(loop, loop.driver.outputs.set_outputs, HIGH).ok
    assert loop.robot.outputs == HIGH
    assert ask(loop, loop.driver.outputs.set_drivers, (0.0, 0.5, 1.0)).ok
    assert tuple(loop.robot.actuators.duties) == (0, 64, 128)


@pytest.mark.parametrize('duty', [-0.1, 1.01, nan])
def test_a_duty_cycle_out_of_range_is_refused(loop, duty):
    answer = ask(loop, loop.driver.outputs.set_drivers, (0.0, 0.0, duty))
    assert not answer.ok
    assert 'driver_2' in answer.text
    assert loop.commands() == []


def test_an_infrared_character_is_sent(loop):
    assert ask(loop, loop.driver.outputs.send_ir, 137).ok
    assert list(loop.robot.actuators.infrared_sent) == [137]


def test_a_song_is_stored_and_plays(loop):
    defined = ask(loop, loop.driver.outputs.define_song, 3, [60, 0, 72], [0.5, 0.25, 0.5])
    assert defined.ok
    assert '1.250 s' in defined.text
    assert loop.robot.speaker.songs[3] == ((60, 32), (0, 16), (72, 32))
    assert ask(loop, loop.driver.outputs.play_song, 3).ok
    assert loop.moved[-1].readings.song_playing
    again = ask(loop, loop.driver.outputs.play_song, 3)
    assert not again.ok
    assert 'a song plays' in again.text


def test_rounding_is_told(loop):
    answer = ask(loop, loop.driver.outputs.define_song, 0, [60, 60], [0.1, 0.001])
    assert answer.ok
    assert 'rounded to 1/64 s' in answer.text
    assert '1 so short' in answer.text


@pytest.mark.parametrize(('number', 'pitches', 'seconds', 'named'), [
    (16, [60], [0.5], 'number'), (0, [60, 61], [0.5], 'durations'), (0, [60], [4.1], 'seconds[0]'),
    (0, [60], [-0.1], 'seconds[0]'), (0, [60], [nan], 'seconds[0]'), (0, [], [], '16 notes'),
    (0, [60] * 17, [0.1] * 17, '16 notes'), (0, [256], [0.1], 'notes[0]'),
])
def test_a_wrong_song_is_refused_before_a_byte_leaves(loop, number, pitches, seconds, named):
    answer = ask(loop, loop.driver.outputs.define_song, number, pitches, seconds)
    assert not answer.ok
    assert named in answer.text
    assert loop.commands() == []


def test_define_and_play_stores_nothing_that_cannot_be_played(loop):
    in_mode(loop, oi.Mode.PASSIVE)
    answer = ask(loop, loop.driver.outputs.define_and_play, 0, [60], [0.5])
    assert not answer.ok
    assert 'set_mode' in answer.text
    assert not loop.robot.speaker.songs
    in_mode(loop, oi.Mode.SAFE)
    assert ask(loop, loop.driver.outputs.define_and_play, 0, [60], [0.5]).ok
    assert loop.moved[-1].readings.song_playing


def test_a_wrong_song_is_neither_stored_nor_played(loop):
    refused = ask(loop, loop.driver.outputs.define_and_play, 3, [60], [4.0])
    assert not refused.ok
    assert 'seconds[0]' in refused.text
    assert loop.commands() == []


def test_a_song_that_was_not_defined_is_refused(loop):
    assert 'define_song' in ask(loop, loop.driver.outputs.play_song, 7).text


@pytest.mark.parametrize('request_of', [
    lambda driver: driver.outputs.set_leds(BLUE, 0, 0),
    lambda driver: driver.outputs.set_outputs(HIGH),
    lambda driver: driver.outputs.set_drivers((0, 0, 1)),
    lambda driver: driver.outputs.send_ir(1),
])
def test_in_passive_the_reply_says_what_to_do(loop, request_of):
    in_mode(loop, oi.Mode.PASSIVE)
    loop.commands()
    answer = request_of(loop.driver).outcome
    assert answer.ok is False
    assert answer.text == 'robot is in PASSIVE: call set_mode with SAFE first'
    assert loop.commands() == []


@pytest.mark.parametrize('request_of', [
    lambda driver: driver.outputs.define_song(0, [60], [0.5]),
    lambda driver: driver.outputs.set_leds(BLUE, 0, 0),
    lambda driver: driver.demos.start(oi.DemoNumber.COVER),
    lambda driver: driver.demos.stop(),
    lambda driver: driver.scripts.define(WAITING),
    lambda driver: driver.scripts.play(0.0, force=True),
    lambda driver: driver.scripts.show(0.0),
])
def test_without_a_robot_every_request_is_refused_at_once(request_of):
    answer = request_of(Driver()).outcome
    assert answer.ok is False
    assert 'port' in answer.text


def test_before_the_mode_is_known_every_request_is_refused():
    driver = Driver()
    driver.connected(0.0)
    packets = driver.plan.full
    driver.receive(packets.pack_frame([0] * len(packets.packets)), 0.1)
    assert driver.state.answered
    assert 'no answer yet' in driver.outputs.set_leds(BLUE, 0, 0).outcome.text


def test_abort_is_no_demo_to_start(loop):
    refused = ask(loop, loop.driver.demos.start, oi.DemoNumber.ABORT)
    assert not refused.ok
    assert 'stop_demo' in refused.text


def test_a_request_whose_robot_is_lost_is_answered(loop):
    pending = loop.driver.outputs.define_song(0, [60], [0.5])
    loop.driver.disconnected('gone')
    assert pending.outcome.ok is False
    assert 'lost' in pending.outcome.text


# Restoring.


def set_everything(loop: Loop) -> None:
    """Set all that is restored, and a low side driver, which is not."""
    assert ask(loop, loop.driver.outputs.set_leds, BLUE, 10, 200).ok
    assert ask(loop, loop.driver.outputs.set_outputs, HIGH).ok
    assert ask(loop, loop.driver.outputs.set_drivers, (1.0, 0.0, 0.0)).ok
    assert ask(loop, loop.driver.outputs.define_song, 3, [60], [0.5]).ok


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
    ask(loop, loop.driver.outputs.set_drivers, (1.0, 1.0, 1.0))
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
    assert answer.ok
    assert loop.robot.demo is oi.DemoNumber.DRIVE_FIGURE_EIGHT
    assert loop.driver.status.wanted is oi.Mode.PASSIVE
    assert loop.driver.status.reason == ''
    assert ask(loop, loop.driver.demos.stop).ok
    assert loop.robot.demo is None
    assert loop.body.truth().speed == pytest.approx(0, abs=0.2)


def test_stop_ends_a_demo_too(loop):
    ask(loop, loop.driver.demos.start, oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    assert loop.driver.stop(loop.now).outcome.ok
    loop.run(0.5)
    assert loop.robot.demo is None
    assert loop.body.truth().speed == 0


def test_stopping_no_demo_leaves_the_mode(loop):
    assert ask(loop, loop.driver.demos.stop).ok
    assert loop.robot.mode is oi.Mode.SAFE


def test_before_docking_the_robot_rests_a_second_in_passive(loop):
    pending = loop.driver.demos.start(oi.DemoNumber.COVER_AND_DOCK)
    loop.run(0.9)
    assert pending.outcome is None
    assert loop.robot.mode is oi.Mode.PASSIVE
    loop.run(0.3)
    assert pending.outcome.ok
    assert loop.robot.demo is oi.DemoNumber.COVER_AND_DOCK


def test_stop_ends_a_demo_that_is_about_to_begin(loop):
    loop.driver.demos.start(oi.DemoNumber.COVER_AND_DOCK)
    loop.run(0.5)
    assert loop.driver.stop(loop.now).outcome.ok
    loop.run(1.0)
    assert loop.robot.demo is None
    assert loop.body.truth().speed == 0


# Scripts.


def test_while_the_robot_drives_no_script_is_played_or_shown(loop):
    ask(loop, loop.driver.scripts.define, WAITING)
    loop.driver.drive(0.2, 0.0, loop.now)
    played = loop.driver.scripts.play(loop.now, force=True)
    shown = loop.driver.scripts.show(loop.now)
    for answer in (played.outcome, shown.outcome):
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
    assert not loop.driver.scripts.playing
    assert loop.body.truth().speed == 0
    loop.drive(0.2, 0.0, 0.5)
    assert loop.body.truth().speed > 0.1
    assert loop.estimate.x == pytest.approx(loop.body.truth().pose.x, abs=0.003)


def test_while_a_script_plays_nothing_is_promised(loop):
    ask(loop, loop.driver.scripts.define, WAITING)
    ask(loop, loop.driver.scripts.play, loop.now, force=False)
    for answer in (ask(loop, loop.driver.outputs.set_leds, BLUE, 0, 0),
                   ask(loop, loop.driver.set_mode, oi.Mode.PASSIVE, loop.now)):
        assert answer.ok is False
        assert 'script' in answer.text
    stopped = loop.driver.stop(loop.now).outcome
    assert not stopped.ok
    assert 'script' in stopped.text
    loop.drive(0.2, 0.0, 0.5)
    assert 'script' in [notice.text for notice in loop.notices][-1]


def test_leds_are_restored_after_a_script_that_enters_safe(loop):
    ask(loop, loop.driver.outputs.set_leds, BLUE, 10, 200)
    ask(loop, loop.driver.scripts.define, parse_script('Safe; Wait Time time=2'))
    ask(loop, loop.driver.scripts.play, loop.now, force=False, seconds=1.0)
    assert loop.robot.lights == (BLUE, 10, 200)


def test_a_script_that_cannot_end_is_refused_unless_forced(loop):
    assert 'cannot end' in ask(loop, loop.driver.scripts.define, ENDLESS).text
    refused = ask(loop, loop.driver.scripts.play, loop.now, force=False)
    assert not refused.ok
    assert 'force' in refused.text
    assert ask(loop, loop.driver.scripts.play, loop.now, force=True).ok
    loop.run(5.0)
    assert loop.driver.scripts.playing
    power_cycle(loop)
    assert not loop.driver.scripts.playing
    assert loop.robot.mode is oi.Mode.SAFE


AWAY_FROM_ITS_GOAL = parse_script(
    'Drive velocity=200 radius=straight; Wait Distance distance=-1000')


def test_a_script_whose_own_motion_leads_away_from_what_it_waits_for_needs_force(loop):
    ask(loop, loop.driver.scripts.define, AWAY_FROM_ITS_GOAL)
    refused = ask(loop, loop.driver.scripts.play, loop.now, force=False)
    assert not refused.ok
    assert 'command 2 of the stored script, Wait Distance distance=-1000, waits' in refused.text
    assert 'the robot drives forwards' in refused.text
    loop.run(1.0)
    assert loop.body.truth().speed == 0
    assert ask(loop, loop.driver.scripts.play, loop.now, force=True).ok


def test_while_a_script_plays_it_is_said_for_how_long_and_what_stops_it(loop):
    ask(loop, loop.driver.scripts.define, WAITING)
    ask(loop, loop.driver.scripts.play, loop.now, force=False, seconds=1.0)
    stopped = loop.driver.stop(loop.now).outcome
    assert 'for about 1 s more' in stopped.text
    assert 'Power button' in stopped.text
    assert loop.driver.health(loop.now).busy == stopped.text


def test_ending_the_driver_while_a_script_holds_the_robot_is_an_error(loop):
    ask(loop, loop.driver.scripts.define, AWAY_FROM_ITS_GOAL)
    ask(loop, loop.driver.scripts.play, loop.now, force=True)
    loop.driver.shut_down(loop.now)
    loop.turn()
    assert loop.notices[-1].severity is Severity.ERROR
    assert 'the driver ends, but a script plays' in loop.notices[-1].text
    assert 'for an unknown time' in loop.notices[-1].text


def test_a_script_whose_end_is_open_says_so(loop):
    script = parse_script('Wait Event event=bump; Wait Distance distance=100')
    message = ask(loop, loop.driver.scripts.define, script).text
    assert 'Wait Event event=bump, Wait Distance distance=100' in message


def test_a_script_that_is_not_known_is_refused_until_it_is_shown(loop):
    loop.robot.script = WAITING.script
    assert not ask(loop, loop.driver.scripts.play, loop.now, force=False).ok
    assert ask(loop, loop.driver.scripts.show, loop.now, seconds=0.5).payload == WAITING.script
    assert ask(loop, loop.driver.scripts.play, loop.now, force=False).ok


def test_an_empty_script_is_refused(loop):
    ask(loop, loop.driver.scripts.define, oi.Script(script=b''))
    assert 'no script' in ask(loop, loop.driver.scripts.play, loop.now, force=True).text


def test_bytes_that_are_no_whole_commands_are_no_script(loop):
    for code in (b'\x91\x00', b'\x05'):
        assert not ask(loop, loop.driver.scripts.define, oi.Script(script=code)).ok
    assert loop.robot.script == b''


@pytest.mark.parametrize('length', [0, 1, 50, 100])
@pytest.mark.parametrize('delay', [0.0, 0.03])
def test_the_stored_script_is_read_back_and_the_stream_goes_on(length, delay):
    loop = Loop(delay=delay)
    loop.run(0.5)
    script = build_script([oi.Safe()] * length)
    ask(loop, loop.driver.scripts.define, script)
    shown = ask(loop, loop.driver.scripts.show, loop.now, seconds=0.6)
    assert (shown.ok, shown.payload) == (True, script.script)
    frames = loop.driver.counts.frames
    loop.run(1.0)
    assert loop.driver.counts.frames - frames > 60
    assert loop.driver.counts.silences == 0


def until_the_script_is_read(loop: Loop) -> Pending:
    """Ask for the script, and cut the line when all that arrives next is its bytes."""
    pending = loop.driver.scripts.show(loop.now)
    while loop.driver.state.activity is not Activity.READING:
        loop.turn()
    loop.cut = True
    return pending


def test_a_script_may_come_in_pieces(loop):
    pending = until_the_script_is_read(loop)
    for byte in bytes((1, *oi.Safe().encode())):
        assert pending.outcome is None
        loop.driver.receive(bytes((byte,)), loop.now)
    assert pending.outcome.payload == oi.Safe().encode()


@pytest.mark.parametrize('reply', [bytes((0, 131)), bytes((101, *bytes(101)))])
def test_a_script_that_comes_damaged_is_given_up(loop, reply):
    pending = until_the_script_is_read(loop)
    loop.driver.receive(reply, loop.now)
    assert pending.outcome.ok is False
    assert 'damaged' in pending.outcome.text
    loop.cut = False
    loop.run(2.0)
    assert loop.driver.state.answered


def test_a_script_that_does_not_come_is_given_up(loop):
    pending = loop.driver.scripts.show(loop.now)
    loop.run(0.05)
    loop.cut = True
    loop.run(1.0)
    assert pending.outcome.ok is False
    loop.cut = False
    loop.run(2.0)
    assert loop.driver.state.answered


def test_a_robot_that_falls_silent_while_it_waits_is_found_again():
    loop = Loop()
    loop.robot.guesses = Guesses(stream_while_waiting=False)
    loop.run(0.3)
    ask(loop, loop.driver.scripts.define, WAITING)
    ask(loop, loop.driver.scripts.play, loop.now, force=False)
    loop.run(4.0)
    assert loop.driver.state.answered
    assert not loop.driver.scripts.playing
    assert loop.body.truth().speed == 0
