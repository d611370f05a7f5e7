# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Animations of the LEDs, outputs by name, and tunes, against the simulated robot."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Settings
from create_oi_ros.driver.outputs import Animation, blink, DARK, FOREVER, spin, Tune
from create_oi_ros.oi.tools.text import parse_script
from create_oi_ros.oi.tools.tunes import parse_tune
from support.asking import ask, in_mode
from support.loop import Loop, STEP

PLAY, ADVANCE, BOTH = oi.LedBits.PLAY, oi.LedBits.ADVANCE, oi.LedBits.PLAY | oi.LedBits.ADVANCE
ALL = oi.Leds(bits=BOTH, color=255, intensity=100)
OWN = (PLAY, 20, 30)
"""The user's own setting."""
OFF = (0, 0, 0)


def leds(bits: oi.LedBits, color: int, intensity: int) -> oi.Leds:
    """Return what LEDs are to show."""
    return oi.Leds(bits=bits, color=color, intensity=intensity)


def start(loop: Loop, steps=None, period: float = 0.3, seconds: float = 1.5) -> Animation:
    """Have an animation shown, after the user's own setting."""
    loop.run(0.5)
    assert ask(loop, loop.driver.outputs.set_leds, leds(*OWN)).text == 'LEDs sent'
    loop.commands()
    animation = Animation(steps or blink(ALL), period, seconds)
    loop.driver.outputs.animate(animation, loop.now)
    return animation


def seen(loop: Loop, seconds: float) -> list[tuple[tuple[int, int, int], float]]:
    """Let time pass; return what the LEDs showed, one after the other, each with its seconds."""
    shown: list[list] = []
    for _ in range(round(seconds / STEP)):
        loop.turn()
        if not shown or shown[-1][0] != loop.robot.lights:
            shown.append([loop.robot.lights, 0.0])
        shown[-1][1] += STEP
    return [(lights, round(lasted, 3)) for lights, lasted in shown]


def test_leds_blink_and_are_then_as_the_user_had_them(loop):
    animation = start(loop)
    shown = seen(loop, 2.0)
    on = (BOTH, 255, 100)
    assert [lights for lights, _ in shown] == [on, OFF] * 5 + [OWN]
    assert all(abs(lasted - 0.15) <= STEP for _, lasted in shown[:-1])
    assert animation.outcome == (True, 'the animation was shown', b'')
    assert animation.seconds == 1.5
    leds = [each for each in loop.commands() if isinstance(each, oi.Leds)]
    assert len(leds) == 11


def test_leds_are_lit_in_turn_and_only_those_that_are_chosen(loop):
    start(loop, spin(ALL), seconds=0.6)
    assert [lights for lights, _ in seen(loop, 1.0)] == [
        (PLAY, 0, 0), (ADVANCE, 0, 0), (0, 255, 100)] * 2 + [OWN]
    assert spin(oi.Leds(bits=ADVANCE, color=9, intensity=0)) == [
        oi.Leds(bits=ADVANCE, color=0, intensity=0)]
    assert DARK not in spin(ALL)


def test_what_is_set_meanwhile_shows_when_the_animation_is_canceled(loop):
    outputs = loop.driver.outputs
    animation = start(loop, seconds=60.0)
    assert ask(loop, outputs.set_leds, leds(ADVANCE, 1, 2)).text == (
        'these LEDs show after the animation')
    assert (ADVANCE, 1, 2) not in [lights for lights, _ in seen(loop, 1.0)]
    another = Animation(blink(ALL), 1.0, 1.0)
    outputs.animate(another, loop.now)
    assert another.outcome.text == (
        'the LEDs are animated: cancel that goal, or wait until it has ended')
    outputs.cancel(another)
    assert animation.outcome is None
    outputs.cancel(animation)
    assert animation.outcome == (False, 'canceled', b'')
    assert abs(animation.seconds - 1.2) <= STEP
    assert seen(loop, 1.0)[-1][0] == (ADVANCE, 1, 2)
    loop.commands()
    loop.run(1.0)
    assert not [each for each in loop.commands() if isinstance(each, oi.Leds)]


def test_an_animation_goes_on_through_a_mode_that_has_leds_and_ends_in_passive(loop):
    animation = start(loop, [ALL], seconds=60.0)
    in_mode(loop, oi.Mode.FULL)
    assert loop.robot.lights == (BOTH, 255, 100)
    in_mode(loop, oi.Mode.PASSIVE)
    assert animation.outcome.text == (
        'the animation ended before its end; robot is in PASSIVE: call set_mode with SAFE first')
    refused = Animation(blink(ALL), 1.0, 1.0)
    loop.driver.outputs.animate(refused, loop.now)
    assert refused.outcome.text == 'robot is in PASSIVE: call set_mode with SAFE first'
    in_mode(loop, oi.Mode.SAFE)
    assert loop.robot.lights == OWN


def test_an_animation_ends_with_the_line(loop):
    animation = start(loop, seconds=60.0)
    loop.cut = True
    loop.run(3.0)
    assert 'the robot was lost' in animation.outcome.text
    loop.cut = False
    loop.run(6.0)
    assert loop.robot.lights == OWN


@pytest.mark.parametrize('mode', [oi.Mode.SAFE, oi.Mode.FULL])
def test_a_driver_that_ends_leaves_the_leds_as_they_were(mode):
    loop = Loop(Settings(mode_on_start=mode, mode_on_exit=oi.Mode.FULL))
    animation = start(loop, [ALL], seconds=60.0)
    loop.run(0.5)
    assert loop.robot.lights == (BOTH, 255, 100)
    loop.driver.shut_down(loop.now)
    loop.robot.receive(loop.driver.data_to_send(), loop.now)
    loop.robot.poll(loop.now + 0.1)
    assert (loop.robot.mode, loop.robot.lights) == (oi.Mode.FULL, OWN)
    assert animation.outcome.text == 'driver is shutting down'


def test_leds_are_dark_after_what_ended_an_animation_and_the_robot_obeys_again():
    loop = Loop(Settings(mode_on_start=oi.Mode.FULL))
    loop.run(0.5)
    for ends in (lambda: loop.driver.scripts.show(loop.now),
                 lambda: loop.driver.scripts.play(loop.now, force=False)):
        assert ask(loop, loop.driver.scripts.define, parse_script('Wait Time time=5')).ok
        animation = Animation([ALL], 0.3, 60.0)
        loop.driver.outputs.animate(animation, loop.now)
        loop.run(0.5)
        assert loop.robot.lights == (BOTH, 255, 100)
        ends()
        loop.run(2.0)
        assert 'the animation ended before its end' in animation.outcome.text
        assert loop.driver.state.refusal is None
        assert loop.robot.lights == OFF


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


# Tunes of more notes than a song holds.


NOTES = parse_tune(' '.join(f'{36 + place}:1/{8 + place % 3}' for place in range(44)))
"""A tune of as many notes as people's have, all of them different."""


def play(loop: Loop, notes=NOTES, iterations: int = 1) -> Tune:
    """Have a tune played."""
    tune = Tune(notes, iterations)
    loop.driver.outputs.play_tune(tune, loop.now)
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
    assert tune.outcome == (True, 'the tune was played', b'')
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
    outputs = loop.driver.outputs
    for number in range(14):
        assert ask(loop, outputs.define_song, number, [60], [0.5]).ok
    tune = play(loop)
    loop.run(0.5)
    assert ask(loop, outputs.define_song, 14, [61], [0.5]).ok  # the one that the tune stored
    kept = {number: loop.robot.speaker.songs[number] for number in range(15)}
    heard(loop, tune)
    assert not tune.outcome.ok and 'all are defined: define fewer' in tune.outcome.text
    assert {number: loop.robot.speaker.songs[number] for number in range(15)} == kept
    ask(loop, outputs.define_song, 15, [62], [0.5])
    loop.run(4.0)
    refused = play(loop)
    assert refused.outcome == (
        False, 'a tune needs two of the 16 songs, and all are defined: define fewer', b'')


def test_a_song_that_the_user_defines_meanwhile_is_given_up(loop):
    tune = play(loop)
    loop.run(0.5)
    stored, = loop.robot.speaker.songs.keys() - {loop.robot.speaker.number}
    assert ask(loop, loop.driver.outputs.define_song, stored, [61], [0.5]).ok
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
        loop, loop.driver.outputs.define_and_play, 0, [60], [1.0], loop.now).text
    loop.driver.outputs.cancel(twice)
    assert tune.outcome is None
    loop.driver.outputs.cancel(tune)
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


def test_a_robot_that_does_not_play_is_said_not_to(loop):
    loop.forged = {'song_playing': 0}
    tune = play(loop)
    loop.run(1.0)
    assert 'the robot does not report it: try again' in tune.outcome.text


def test_a_tune_ends_with_the_mode_that_it_needs(loop):
    tune = play(loop)
    loop.run(0.5)
    in_mode(loop, oi.Mode.PASSIVE)
    loop.run(3.0)
    assert tune.outcome.text == (
        'the tune ended before its end; robot is in PASSIVE: call set_mode with SAFE first')
    assert 'call set_mode with SAFE first' in play(loop).outcome.text


def test_a_tune_ends_with_the_line(loop):
    tune = play(loop)
    loop.run(0.5)
    loop.cut = True
    loop.run(3.0)
    assert 'the robot was lost' in tune.outcome.text
