# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What services and tunes ask of the driver, played against the simulated robot."""

from functools import partial
from math import nan

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, Driver, Settings
from create_oi_ros.driver.outbox import farewell, LOST
from create_oi_ros.driver.songs import FOREVER, Tune
from create_oi_ros.oi.tools.text import parse_script
from create_oi_ros.oi.tools.tunes import parse_tune
from support.asking import ask, in_mode, power_cycle
from support.loop import Loop

LEDS = oi.Leds(bits=oi.LedBits.PLAY | oi.LedBits.ADVANCE, color=10, intensity=200)
HIGH = oi.OutputBits.OUTPUT_0 | oi.OutputBits.OUTPUT_2


# Actuators.


def test_rounding_is_told(loop):
    answer = ask(loop, loop.driver.songs.define, 0, [60, 60], [0.1, 0.001])
    assert answer.ok
    assert answer.text.endswith('rounded to 1/64 s, by 6 ms at most')
    longer = ask(loop, loop.driver.songs.define, 0, [60, 60, 60], [0.5, 2.006, 0.0])
    assert longer.text.endswith('takes 2.500 s, asked for 2.506 s: notes are rounded to 1/64 s, '
                                'by 6 ms at most')


@pytest.mark.parametrize(('number', 'pitches', 'seconds', 'named'), [
    (16, [60], [0.5], 'number'), (0, [60, 61], [0.5], 'durations'), (0, [60], [4.1], 'seconds[0]'),
    (0, [60], [-0.1], 'seconds[0]'), (0, [60], [nan], 'seconds[0]'), (0, [], [], '16 notes'),
    (0, [60] * 17, [0.1] * 17, 'a song holds 16: play more by the action audio_note_sequence'),
    (0, [256], [0.1], 'notes[0]'),
])
def test_a_wrong_song_is_refused_before_a_byte_leaves(loop, number, pitches, seconds, named):
    songs, song = loop.driver.songs, (number, pitches, seconds)
    for answer in (ask(loop, songs.define, *song),
                   ask(loop, songs.define_and_play, *song, loop.now)):
        assert not answer.ok
        assert named in answer.text
    assert loop.commands() == []


def test_define_and_play_stores_nothing_that_cannot_be_played(loop):
    in_mode(loop, oi.Mode.PASSIVE)
    answer = ask(loop, loop.driver.songs.define_and_play, 0, [60], [0.5], loop.now)
    assert not answer.ok
    assert 'set_mode' in answer.text
    assert not loop.robot.speaker.songs
    in_mode(loop, oi.Mode.SAFE)
    assert ask(loop, loop.driver.songs.define_and_play, 0, [60], [0.5], loop.now).ok
    assert loop.moved[-1].readings.song_playing


@pytest.mark.parametrize(('first', 'second'), [(0, 1), (3, 3)])
def test_of_two_songs_sent_at_once_only_the_one_that_plays_is_said_to_play(loop, first, second):
    songs = loop.driver.songs
    one = songs.define_and_play(first, [60], [1.0], loop.now)
    two = songs.define_and_play(second, [72], [2.0], loop.now)
    assert not two.outcome.ok
    assert f'song {first} is about to play' in two.outcome.text
    loop.run(0.2)
    assert one.outcome.ok and one.outcome.text.endswith(f'song {first} plays')
    assert loop.robot.speaker.songs == {first: ((60, 64),)}


def test_a_song_that_the_robot_does_not_play_is_said_not_to(loop):
    assert ask(loop, loop.driver.songs.define, 2, [60], [1.0]).ok
    play = loop.driver.songs.play(2, loop.now)
    loop.driver.poll(loop.now)
    assert loop.driver.data_to_send()  # lost on the line
    loop.run(0.4)
    assert play.outcome is None
    loop.run(0.3)
    assert (play.outcome.ok, 'does not report it' in play.outcome.text) == (False, True)
    again = loop.driver.songs.play(2, loop.now)
    loop.driver.disconnected('gone')
    assert not again.outcome.ok


def test_a_song_too_short_to_be_seen_is_said_to_be_sent(loop):
    answer = ask(loop, loop.driver.songs.define_and_play, 2, [60], [0.02], loop.now)
    assert answer.ok
    assert answer.text.endswith('song 2 sent to play; it is too short to be seen playing')


def test_an_output_is_set_by_its_name_and_the_others_stay():
    loop = Loop(Settings(output_names=('lamp', 'door', 'output_2')))
    loop.run(1.0)
    outputs, bits = loop.driver.outputs, oi.OutputBits
    assert ask(loop, outputs.set_outputs, bits.OUTPUT_2).ok
    assert ask(loop, outputs.set_output, 'door', high=True).text == 'digital outputs sent'
    assert loop.robot.outputs == bits.OUTPUT_1 | bits.OUTPUT_2
    assert ask(loop, outputs.set_output, 'output_2', high=False).ok
    assert loop.robot.outputs == bits.OUTPUT_1
    assert ask(loop, outputs.set_output, 'lamb', high=True).text == (
        "no output is called 'lamb'; output_names: lamp, door, output_2")
    in_mode(loop, oi.Mode.PASSIVE)
    assert 'call set_mode with SAFE first' in ask(loop, outputs.set_output, 'lamp', high=True).text


@pytest.mark.parametrize('request_of', [
    lambda driver: driver.outputs.set_leds(LEDS),
    lambda driver: driver.outputs.set_outputs(HIGH),
    lambda driver: driver.outputs.set_drivers((0, 0, 1)),
    lambda driver: driver.outputs.send_ir(1),
    lambda driver: driver.songs.define(0, [60], [0.5]),
    lambda driver: driver.modes.start_demo(oi.DemoNumber.COVER),
    lambda driver: driver.scripts.define(parse_script('Wait Time time=20')),
    lambda driver: driver.scripts.play(0.0, force=True),
    lambda driver: driver.stop(0.0),
])
def test_what_no_packet_shows_is_only_said_to_be_sent(loop, request_of):
    pending = request_of(loop.driver)
    loop.run(0.1)
    assert pending.outcome.ok
    assert 'sent' in pending.outcome.text


def test_a_song_that_was_not_defined_is_refused(loop):
    assert 'define_song' in ask(loop, loop.driver.songs.play, 7, loop.now).text


def test_before_the_mode_is_known_every_request_is_refused():
    driver = Driver()
    driver.connected(0.0)
    packets = driver.plan.full
    driver.receive(packets.pack_frame([0] * len(packets.packets)), 0.1)
    assert driver.state.answered
    assert 'no answer yet' in driver.outputs.set_leds(LEDS).outcome.text


def test_what_was_queued_for_a_robot_that_is_lost_is_never_sent(loop):
    beam = loop.driver.outputs.send_ir(7)
    loop.driver.disconnected('gone')
    assert beam.outcome == (False, LOST)
    loop.driver.connected(loop.now)
    loop.run(1.0)
    assert loop.driver.state.answered and oi.SendIr(byte=7) not in loop.commands()


# Restoring.


def set_everything(loop: Loop) -> None:
    """Set all that is restored, and a low side driver, which is not."""
    assert ask(loop, loop.driver.outputs.set_leds, LEDS).ok
    assert ask(loop, loop.driver.outputs.set_outputs, HIGH).ok
    assert ask(loop, loop.driver.outputs.set_drivers, (1.0, 0.0, 0.0)).ok
    assert ask(loop, loop.driver.songs.define, 3, [60], [0.5]).ok


def assert_restored(loop: Loop) -> None:
    """See all of it at the robot."""
    assert loop.robot.mode in oi.ACTUATE
    assert loop.robot.lights == (LEDS.bits, 10, 200)
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


def drop_a_wheel(loop: Loop) -> None:
    """Let the robot leave Safe, and bring it back."""
    loop.body.drop(left=True)
    loop.run(0.3)
    loop.body.drop()
    loop.run(2.0)
    loop.drive(0.1, 0.0, 0.5)


@pytest.mark.parametrize('happens', [power_cycle, drop_a_wheel, *(
    partial(Loop.lose_line, seconds=seconds) for seconds in (0.7, 1.2, 2.5, 8.0))])
def test_all_is_restored_but_low_side_drivers(loop, happens):
    set_everything(loop)
    happens(loop)
    loop.run(2.0)
    assert_restored(loop)
    assert tuple(loop.robot.actuators.duties) == (0, 0, 0)


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
    loop.drive(0.2, 0.0, 1.0)
    assert loop.body.truth().speed == 0


# Demos.


def test_stopping_a_demo_leaves_passive_and_stopping_none_leaves_the_mode(loop):
    assert ask(loop, loop.driver.modes.stop_demo).ok
    assert loop.robot.mode is oi.Mode.SAFE
    loop.drive(0.1, 0.0, 0.1)
    modes, demo = loop.driver.modes, oi.DemoNumber.DRIVE_FIGURE_EIGHT
    assert ask(loop, modes.start_demo, demo, seconds=0.1).ok
    assert ask(loop, modes.stop_demo, seconds=0.1).ok
    assert (loop.robot.mode, loop.robot.demo) == (oi.Mode.PASSIVE, None)
    assert loop.driver.state.activity is Activity.IDLE


def test_before_docking_the_robot_rests_a_second_in_passive(loop):
    pending = loop.driver.modes.start_demo(oi.DemoNumber.COVER_AND_DOCK)
    loop.run(0.9)
    assert pending.outcome is None
    assert loop.robot.mode is oi.Mode.PASSIVE
    loop.run(0.3)
    assert pending.outcome.ok
    assert loop.robot.demo is oi.DemoNumber.COVER_AND_DOCK


def test_a_driver_that_ends_ends_a_demo_that_has_just_begun(loop):
    loop.driver.modes.start_demo(oi.DemoNumber.COVER)
    loop.turn()
    assert loop.robot.demo is oi.DemoNumber.COVER
    assert loop.driver.status.actual is oi.Mode.SAFE, 'no frame shows it yet'
    loop.driver.shut_down(loop.now)
    loop.commands()
    loop.turn()
    assert loop.commands() == farewell(oi.Mode.PASSIVE, oi.Mode.PASSIVE)


def test_stop_ends_a_demo_also_where_the_robot_seems_to_ignore_commands(loop):
    ask(loop, loop.driver.modes.start_demo, oi.DemoNumber.DRIVE_FIGURE_EIGHT)
    receive, loop.robot.receive = loop.robot.receive, lambda *_: None
    loop.run(1.5)
    assert loop.driver.health(loop.now).suspects_commands
    loop.robot.receive = receive
    loop.driver.stop(loop.now)
    loop.run(0.1)
    assert loop.robot.demo is None


# Tunes of more notes than a song of the robot holds.


NOTES = parse_tune(' '.join(f'{36 + place}:1/{8 + place % 3}' for place in range(44)))
"""A tune of as many notes as people's have, all of them different."""


def play(loop: Loop, notes=NOTES, iterations: int = 1) -> Tune:
    """Have a tune played."""
    tune = Tune(notes, iterations)
    loop.driver.songs.play_tune(tune, loop.now)
    return tune


def heard(loop: Loop, tune: Tune, seconds: float = 30.0) -> list[tuple[int, float]]:
    """Let a tune play; return what was heard: each sound, or rest, with its seconds."""
    sounds: list[tuple[int, float]] = []
    until = loop.now + seconds
    while tune.outcome is None and loop.now < until:
        loop.turn()
        note = loop.robot.note
        if not sounds or sounds[-1][0] != note:
            sounds.append((note, loop.now))
    return [(note, end - begin) for (note, begin), (_, end) in zip(
        sounds, [*sounds[1:], (oi.REST, loop.now)])]


def test_a_long_tune_is_heard_whole_with_short_pauses_between_its_songs(loop):
    tune = play(loop)
    assert [len(song) for song in tune.songs] == [14, 15, 15]
    sounds = heard(loop, tune)
    assert tune.outcome == (True, 'the tune was played')
    assert [note for note, _ in sounds if note != oi.REST] == [note.number for note in NOTES]
    pauses = [seconds for note, seconds in sounds[1:-1] if note == oi.REST]
    assert max(pauses, default=0.0) <= oi.SLOT
    assert (tune.iterations_played, tune.note) == (1, 43)
    lasts = sum(note.duration for note in NOTES) / oi.NOTES_PER_SECOND
    assert lasts < tune.seconds < lasts + 3 * 2 * oi.SLOT


def test_the_note_that_sounds_is_told(loop):
    tune, told = play(loop), []
    while tune.outcome is None:
        loop.turn()
        sounds = loop.robot.note
        if tune.note >= 0 and sounds != oi.REST:
            told.append(NOTES[tune.note].number - sounds)
    assert set(told) <= {0, -1} and told.count(0) > 0.8 * len(told)


def test_songs_of_the_user_are_never_touched(loop):
    songs = loop.driver.songs
    for number in range(14):
        assert ask(loop, songs.define, number, [60], [0.5]).ok
    tune = play(loop)
    loop.run(0.5)
    assert ask(loop, songs.define, 14, [61], [0.5]).ok  # the one that the tune stored
    kept = {number: loop.robot.speaker.songs[number] for number in range(15)}
    heard(loop, tune)
    assert not tune.outcome.ok and 'all are defined: define fewer' in tune.outcome.text
    assert {number: loop.robot.speaker.songs[number] for number in range(15)} == kept
    ask(loop, songs.define, 15, [62], [0.5])
    loop.run(4.0)
    refused = play(loop)
    assert refused.outcome == (
        False, 'a tune needs two of the 16 songs, and all are defined: define fewer')


def test_a_song_that_the_user_defines_meanwhile_is_given_up(loop):
    tune = play(loop)
    loop.run(0.5)
    stored, = loop.robot.speaker.songs.keys() - {loop.robot.speaker.number}
    assert ask(loop, loop.driver.songs.define, stored, [61], [0.5]).ok
    numbers = [note for note, _ in heard(loop, tune) if note != oi.REST]
    assert tune.outcome.ok and numbers[-30:] == [note.number for note in NOTES[-30:]]
    assert loop.robot.speaker.songs[stored] == ((61, 32),)


def test_a_tune_is_repeated_until_it_is_canceled(loop):
    tune = play(loop, parse_tune('C4:1/4 E4:1/4'), FOREVER)
    loop.run(2.0)
    assert tune.outcome is None and tune.iterations_played == 3
    twice = play(loop, parse_tune('C4:1/64 E4:1/64'), 2)
    assert 'a tune plays: cancel its goal' in twice.outcome.text
    assert 'a tune plays' in ask(
        loop, loop.driver.songs.define_and_play, 0, [60], [1.0], loop.now).text
    loop.driver.songs.cancel(twice)
    assert tune.outcome is None
    loop.driver.songs.cancel(tune)
    assert tune.outcome.text == 'canceled; the song that plays goes on to its end'
    loop.run(1.0)
    assert loop.robot.note == oi.REST
    loop.commands()
    loop.run(2.0)
    assert not [each for each in loop.commands() if isinstance(each, oi.PlaySong)]


def test_a_tune_too_short_to_be_seen_is_played_all_the_same(loop):
    loop.forged = {'song_playing': 0}
    tune = play(loop, parse_tune('C4:1/64'), 2)
    loop.run(1.5)
    assert tune.outcome.ok and tune.iterations_played == 2


def test_a_tune_ends_with_the_mode_that_it_needs(loop):
    tune = play(loop)
    loop.run(0.5)
    in_mode(loop, oi.Mode.PASSIVE)
    loop.run(3.0)
    assert tune.outcome.text == (
        'the tune ended before its end; robot is in PASSIVE: call set_mode with SAFE first')
    assert 'call set_mode with SAFE first' in play(loop).outcome.text
