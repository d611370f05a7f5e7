# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Tunes of more notes than a song of the robot holds, against the simulated robot."""

from create_oi_ros import oi
from create_oi_ros.driver.songs import FOREVER, Tune
from create_oi_ros.oi.tools.tunes import parse_tune
from support.asking import ask, in_mode
from support.loop import Loop

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
