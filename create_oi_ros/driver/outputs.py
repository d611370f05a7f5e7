# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
LEDs, digital outputs, low side drivers, infrared and songs: sent, stored, restored.

The robot forgets songs when it is switched off, and its LEDs when the mode changes; it keeps the
digital outputs. Songs, LEDs and digital outputs are restored. The low side drivers may turn
motors, so they stay off. Of all these the robot reports only songs; the other replies say what was
sent.
"""

from collections.abc import Sequence

from .. import oi
from ..oi.commands import DUTY, NOTE_TIME
from ..robot import MILLI
from .core import Core
from .outbox import done, Outcome, Pending, refused
from .tunes import MOST_NOTES, SHORTEST_SEEN, SONG_TIMEOUT, SONGS, Tunes

LONGEST_NOTE = NOTE_TIME.high / oi.NOTES_PER_SECOND
"""Seconds that a note can last."""
FULL_DUTY = DUTY.high
"""What turns a low side driver on all the time (manual: PWM Low Side Drivers)."""

WAIT = 'wait until the topic `song` says that it has ended'


class Outputs:
    """Everything that a request can set, except mode, wheels, demos and scripts."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self.songs: dict[int, oi.Song] = {}
        """The songs that were defined, by number."""
        self.tunes = Tunes(core, self.songs, self._cannot_play)
        self._to_restore: dict[type[oi.Command], oi.Command] = {}
        self._play_request = done('no request')
        self._played = Outcome(True, '')
        self._playing = 0
        """Number of the song that the robot was told to play last."""
        self._deadline = 0.0

    def set_leds(self, bits: oi.LedBits, color: int, intensity: int) -> Pending:
        """Light Play and Advance, and Power in a colour (0 green, 255 red) and intensity."""
        return self._set(oi.Leds(bits=bits, color=color, intensity=intensity), 'LEDs sent')

    def set_outputs(self, bits: oi.OutputBits) -> Pending:
        """Set the digital outputs of the cargo bay."""
        return self._set(oi.DigitalOutputs(bits=bits), 'digital outputs sent')

    def set_drivers(self, duties: Sequence[float]) -> Pending:
        """Set the duty cycles of the low side drivers 0, 1 and 2, each 0 to 1."""
        for number, duty in enumerate(duties):
            if not 0 <= duty <= 1:
                return refused(f'driver_{number} = {duty:g}; allowed: 0.0 (off) to 1.0 (on)')
        zero, one, two = (round(duty * FULL_DUTY) for duty in duties)
        return self._core.request(
            oi.PwmLowSideDrivers(driver_0=zero, driver_1=one, driver_2=two),
            f'low side drivers 0, 1, 2 sent: {zero}, {one}, {two} of {FULL_DUTY}')

    def send_ir(self, character: int) -> Pending:
        """Send an infrared character, 0 to 255."""
        return self._core.request(oi.SendIr(byte=character), f'character {character} sent')

    def define_song(
        self, number: int, pitches: Sequence[int], seconds: Sequence[float],
    ) -> Pending:
        """Store a song: MIDI numbers, and durations in seconds, rounded to 1/64 s."""
        try:
            song = _song(number, pitches, seconds)
        except ValueError as error:
            return refused(str(error))
        request = self._core.request(song, _stored(number, seconds))
        if request.outcome is None:
            self.songs[number] = song
        return request

    def define_and_play(
        self, number: int, pitches: Sequence[int], seconds: Sequence[float], now: float,
    ) -> Pending:
        """Store a song and play it; nothing is stored where it could not be played."""
        why = self._cannot_play()
        if why is not None:
            return refused(why)
        stored = self.define_song(number, pitches, seconds)
        if stored.outcome is not None:
            return stored
        return self._play(number, now, f'{_stored(number, seconds)}; ')

    def play_song(self, number: int, now: float) -> Pending:
        """Play a stored song, unless one plays."""
        if number not in self.songs:
            known = ', '.join(map(str, sorted(self.songs))) or 'none yet'
            return refused(f'song {number} is not defined: call define_song; defined: {known}')
        why = self._cannot_play()
        if why is not None:
            return refused(why)
        return self._play(number, now)

    def _play(self, number: int, now: float, stored: str = '') -> Pending:
        """Play a song; the request ends when the robot reports it, or does not in time."""
        length = sum(note.duration for note in self.songs[number].notes) / oi.NOTES_PER_SECOND
        if length < SHORTEST_SEEN:
            return self._core.request(oi.PlaySong(number=number), (
                f'{stored}song {number} sent to play; it is too short to be seen playing'))
        self._core.outbox.send(oi.PlaySong(number=number))
        self._play_request, self._playing = Pending(), number
        self._played = Outcome(True, f'{stored}song {number} plays')
        self._deadline = now + SONG_TIMEOUT
        return self._play_request

    @property
    def awaited(self) -> bool:
        """Whether the robot has not reported yet that it plays a song."""
        return self._play_request.outcome is None

    def observe(self, readings: oi.Readings, now: float) -> None:
        """End the request for a song that plays: none did when it was sent. Go on with a tune."""
        self.tunes.observe(readings, now)
        if self.awaited and readings.song_playing and readings.song_number in (
                self._playing, None):
            self._play_request.settle(self._played)

    def check_timeout(self, now: float) -> None:
        """End the request for a song that the robot does not play, and a tune."""
        self.tunes.check_timeout(now)
        if self.awaited and now > self._deadline:
            self._play_request.end(
                False, f'song {self._playing} was sent to play, but the robot does not report it: '
                'try again')

    def fail(self, why: str) -> None:
        """End the tune, and the request for a song that has not been reported."""
        self.tunes.fail(why)
        self._play_request.end(False, why)

    def restore_songs(self) -> None:
        """Store the songs again: the robot may have been switched off."""
        for song in self.songs.values():
            self._core.outbox.send(song)

    def restore(self) -> None:
        """Set LEDs and outputs again: the mode has changed, or the robot was switched off."""
        for command in self._to_restore.values():
            self._core.outbox.send(command)

    def _cannot_play(self) -> str | None:
        if self.tunes.tune is not None:
            return 'a tune plays: cancel its goal, or wait until that has ended'
        readings = self._core.readings
        if readings.has('song_playing') and readings.song_playing:
            return f'a song plays: {WAIT}'
        if self.awaited:
            return f'song {self._playing} is about to play: {WAIT}'
        return self._core.refusal(oi.PlaySong)

    def _set(self, command: oi.Command, done: str) -> Pending:
        request = self._core.request(command, done)
        if request.outcome is None:
            self._to_restore[type(command)] = command
        return request


def _song(number: int, pitches: Sequence[int], seconds: Sequence[float]) -> oi.Song:
    """Make a song; ValueError says what is wrong that the command itself does not check."""
    if len(pitches) != len(seconds):
        raise ValueError(
            f'{len(pitches)} pitches but {len(seconds)} durations; give one for each note')
    if len(pitches) > MOST_NOTES:
        raise ValueError(f'{len(pitches)} notes, but a song holds {MOST_NOTES}: {_split(pitches)}')
    for place, length in enumerate(seconds):
        if not 0 <= length <= LONGEST_NOTE:
            raise ValueError(f'seconds[{place}] = {length:g}; allowed: 0 to {LONGEST_NOTE:g}')
    lengths = [round(length * oi.NOTES_PER_SECOND) for length in seconds]
    return oi.Song(number=number, notes=tuple(oi.Note(*note) for note in zip(pitches, lengths)))


def _split(notes: Sequence[int]) -> str:
    """Say how to store and play more notes than one song holds."""
    parts, rest = divmod(len(notes), MOST_NOTES)
    sizes = [str(MOST_NOTES)] * parts + [str(rest)] * (rest > 0)
    if len(sizes) > SONGS:
        return f'{SONGS} songs hold {SONGS * MOST_NOTES} at most; leave some out'
    return (f'define songs of {", ".join(sizes[:-1])} and {sizes[-1]} notes, and play each when '
            'the one before has ended')


def _stored(number: int, seconds: Sequence[float]) -> str:
    """Say that a song was sent, and how rounding to 1/64 s changes its durations."""
    lengths = [round(length * oi.NOTES_PER_SECOND) for length in seconds]
    played = sum(lengths) / oi.NOTES_PER_SECOND
    worst = max((abs(length / oi.NOTES_PER_SECOND - wanted)
                 for length, wanted in zip(lengths, seconds)), default=0.0)
    vanished = sum(1 for length, wanted in zip(lengths, seconds) if wanted > 0 == length)
    gone = f', {vanished} so short that they are left out' if vanished else ''
    if worst < 0.0005:
        return f'song {number} sent; it takes {played:.3f} s'
    return (f'song {number} sent; it takes {played:.3f} s, asked for {sum(seconds):.3f} s: '
            f'notes are rounded to 1/64 s, by {worst / MILLI:.0f} ms at most{gone}')
