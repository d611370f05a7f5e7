# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
LEDs, digital outputs, low side drivers, infrared and songs: sent, stored, restored.

The robot forgets songs when it is switched off, and its LEDs when the mode changes; it keeps the
digital outputs. Songs, LEDs and digital outputs are restored. The low side drivers may turn
motors, so they stay off.
"""

from collections.abc import Sequence

from .. import oi
from ..oi.commands import DUTY, NOTE_TIME
from ..robot import MILLI
from .outbox import Outbox
from .pending import Pending, refused
from .requests import Requests
from .tracking import Tracking

LONGEST_NOTE = NOTE_TIME.high / oi.NOTES_PER_SECOND
"""Seconds that a note can last."""
FULL_DUTY = DUTY.high
"""What turns a low side driver on all the time (manual: PWM Low Side Drivers)."""


class Outputs:
    """Everything that a request can set, except mode, wheels, demos and scripts."""

    def __init__(self, outbox: Outbox, requests: Requests, tracking: Tracking) -> None:
        self._outbox = outbox
        self._requests = requests
        self._tracking = tracking
        self.songs: dict[int, oi.Song] = {}
        """The songs that were defined, by number."""
        self._to_restore: dict[type[oi.Command], oi.Command] = {}

    def set_leds(self, bits: oi.LedBits, color: int, intensity: int) -> Pending:
        """Light Play and Advance, and Power in a colour (0 green, 255 red) and intensity."""
        return self._set(oi.Leds(bits=bits, color=color, intensity=intensity), 'LEDs set')

    def set_outputs(self, bits: oi.OutputBits) -> Pending:
        """Set the digital outputs of the cargo bay."""
        return self._set(oi.DigitalOutputs(bits=bits), 'digital outputs set')

    def set_drivers(self, duties: Sequence[float]) -> Pending:
        """Set the duty cycles of the low side drivers 0, 1 and 2, each 0 to 1."""
        for number, duty in enumerate(duties):
            if not 0 <= duty <= 1:
                return refused(f'driver_{number} = {duty:g}; allowed: 0.0 (off) to 1.0 (on)')
        zero, one, two = (round(duty * FULL_DUTY) for duty in duties)
        return self._requests.send(
            oi.PwmLowSideDrivers(driver_0=zero, driver_1=one, driver_2=two),
            f'low side drivers 0, 1, 2 set to {zero}, {one}, {two} of {FULL_DUTY}')

    def send_ir(self, character: int) -> Pending:
        """Send an infrared character, 0 to 255."""
        return self._requests.send(oi.SendIr(byte=character), f'character {character} sent')

    def define_song(
        self, number: int, pitches: Sequence[int], seconds: Sequence[float],
    ) -> Pending:
        """Store a song: MIDI numbers, and durations in seconds, rounded to 1/64 s."""
        try:
            song = _song(number, pitches, seconds)
        except ValueError as error:
            return refused(str(error))
        request = self._requests.send(song, _stored(number, seconds))
        if request.outcome is None:
            self.songs[number] = song
        return request

    def define_and_play(
        self, number: int, pitches: Sequence[int], seconds: Sequence[float],
    ) -> Pending:
        """Store a song and play it; nothing is stored where it could not be played."""
        why = self._cannot_play()
        if why is not None:
            return refused(why)
        stored = self.define_song(number, pitches, seconds)
        if stored.outcome is not None:
            return stored
        return self._requests.send(
            oi.PlaySong(number=number), f'{_stored(number, seconds)}; song {number} plays')

    def play_song(self, number: int) -> Pending:
        """Play a stored song, unless one plays."""
        if number not in self.songs:
            known = ', '.join(map(str, sorted(self.songs))) or 'none yet'
            return refused(f'song {number} is not defined: call define_song; defined: {known}')
        why = self._cannot_play()
        if why is not None:
            return refused(why)
        return self._requests.send(oi.PlaySong(number=number), f'song {number} plays')

    def restore_songs(self) -> None:
        """Store the songs again: the robot may have been switched off."""
        for song in self.songs.values():
            self._outbox.send(song)

    def restore(self) -> None:
        """Set LEDs and outputs again: the mode has changed, or the robot was switched off."""
        for command in self._to_restore.values():
            self._outbox.send(command)

    def _cannot_play(self) -> str | None:
        readings = self._tracking.readings
        if readings.has('song_playing') and readings.song_playing:
            return 'a song plays: wait until the topic `song` says that it has ended'
        return self._requests.refusal(oi.PlaySong)

    def _set(self, command: oi.Command, done: str) -> Pending:
        request = self._requests.send(command, done)
        if request.outcome is None:
            self._to_restore[type(command)] = command
        return request


def _song(number: int, pitches: Sequence[int], seconds: Sequence[float]) -> oi.Song:
    """Make a song; ValueError says what is wrong that the command itself does not check."""
    if len(pitches) != len(seconds):
        raise ValueError(
            f'{len(pitches)} pitches but {len(seconds)} durations; give one for each note')
    for place, length in enumerate(seconds):
        if not 0 <= length <= LONGEST_NOTE:
            raise ValueError(f'seconds[{place}] = {length:g}; allowed: 0 to {LONGEST_NOTE:g}')
    lengths = [round(length * oi.NOTES_PER_SECOND) for length in seconds]
    return oi.Song(number=number, notes=tuple(oi.Note(*note) for note in zip(pitches, lengths)))


def _stored(number: int, seconds: Sequence[float]) -> str:
    """Say that a song is stored, and how rounding to 1/64 s changes its durations."""
    lengths = [round(length * oi.NOTES_PER_SECOND) for length in seconds]
    played = sum(lengths) / oi.NOTES_PER_SECOND
    worst = max((abs(length / oi.NOTES_PER_SECOND - wanted)
                 for length, wanted in zip(lengths, seconds)), default=0.0)
    vanished = sum(1 for length, wanted in zip(lengths, seconds) if wanted > 0 == length)
    gone = f', {vanished} so short that they are left out' if vanished else ''
    if worst < 0.0005:
        return f'song {number} stored; it takes {played:.3f} s'
    return (f'song {number} stored; it takes {played:.3f} s, asked for {sum(seconds):.3f} s: '
            f'notes are rounded to 1/64 s, by {worst / MILLI:.0f} ms at most{gone}')
