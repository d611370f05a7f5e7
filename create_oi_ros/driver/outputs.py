"""
LEDs, outputs, drivers, infrared and songs: sent, remembered, restored.

The robot forgets songs when it is switched off and its LEDs when the mode changes, and keeps the
digital outputs at what they were. What was set by request and is safe to repeat is set again;
the low side drivers, which may turn motors, stay off.
"""

from collections.abc import Callable, Sequence

from .. import oi
from .outbox import Outbox
from .requests import Reply, Requests

LONGEST_NOTE = 255 / oi.NOTES_PER_SECOND
"""Seconds."""
FULL_DUTY = 128
"""What a low side driver is told to be on all the time (manual: PWM Low Side Drivers)."""


class Actuators:
    """Everything of the robot that a request can set, but for mode, wheels, demos and scripts."""

    def __init__(self, outbox: Outbox, requests: Requests, readings: Callable[[], oi.Readings],
    ) -> None:
        """Take where commands go, what checks them, and what gives the newest readings."""
        self._outbox = outbox
        self._requests = requests
        self._readings = readings
        self.songs: dict[int, oi.Song] = {}
        """The songs that were defined, by number."""
        self._lit: dict[type[oi.Command], oi.Command] = {}

    def set_leds(
        self, bits: oi.LedBits, color: int, intensity: int, reply: Reply,
    ) -> None:
        """Light Play and Advance, and Power in a colour (0 green, 255 red) and intensity."""
        self._keep(oi.Leds(bits=bits, color=color, intensity=intensity), reply, 'LEDs set')

    def set_outputs(self, bits: oi.OutputBits, reply: Reply) -> None:
        """Set the digital outputs of the cargo bay."""
        self._keep(oi.DigitalOutputs(bits=bits), reply, 'digital outputs set')

    def set_drivers(self, duties: Sequence[float], reply: Reply) -> None:
        """Set the duty cycles of the low side drivers 0, 1 and 2, each 0 to 1."""
        for number, duty in enumerate(duties):
            if not 0 <= duty <= 1:
                reply(False, f'driver_{number} = {duty:g}; allowed: 0.0 (off) to 1.0 (on)')
                return
        zero, one, two = (round(duty * FULL_DUTY) for duty in duties)
        self._requests.send(
            oi.PwmLowSideDrivers(driver_0=zero, driver_1=one, driver_2=two), reply,
            f'low side drivers 0, 1, 2 set to {zero}, {one}, {two} of {FULL_DUTY}')

    def send_ir(self, character: int, reply: Reply) -> None:
        """Send an infrared character, 0 to 255."""
        self._requests.send(oi.SendIr(byte=character), reply, f'character {character} sent')

    def define_song(
        self, number: int, pitches: Sequence[int], seconds: Sequence[float], reply: Reply,
    ) -> None:
        """
        Store a song: MIDI numbers and durations in seconds, which are rounded to 1/64 s.

        The reply says what rounding did.
        """
        refusal = _wrong_notes(pitches, seconds)
        if refusal:
            reply(False, refusal)
            return
        lengths = [round(length * oi.NOTES_PER_SECOND) for length in seconds]
        song = oi.Song(
            number=number, notes=tuple(oi.Note(*note) for note in zip(pitches, lengths)))
        if self._requests.send(song, reply, f'song {number} stored; {_rounding(seconds)}'):
            self.songs[number] = song

    def define_and_play(
        self, number: int, pitches: Sequence[int], seconds: Sequence[float], reply: Reply,
    ) -> None:
        """Store a song and play it; nothing is stored where it could not be played."""
        refusal = self._cannot_play()
        if refusal:
            reply(False, refusal)
            return

        def stored(success: bool, message: str) -> None:
            if success:
                self.play_song(number, lambda plays, then: reply(plays, f'{message}; {then}'))
            else:
                reply(success, message)
        self.define_song(number, pitches, seconds, stored)

    def play_song(self, number: int, reply: Reply) -> None:
        """Play a stored song, unless one plays."""
        refusal = self._cannot_play()
        if number not in self.songs:
            known = ', '.join(map(str, sorted(self.songs))) or 'none yet'
            refusal = f'song {number} is not defined: call define_song; defined: {known}'
        if refusal:
            reply(False, refusal)
        else:
            self._requests.send(oi.PlaySong(number=number), reply, f'song {number} plays')

    def restore_songs(self) -> None:
        """Store the songs again: the robot may have been switched off."""
        for song in self.songs.values():
            self._outbox.send(song)

    def restore(self) -> None:
        """Set LEDs and outputs again: the mode has changed, or the robot was switched off."""
        for command in self._lit.values():
            self._outbox.send(command)

    def _cannot_play(self) -> str:
        readings = self._readings()
        if readings.has('song_playing') and readings.song_playing:
            return 'a song plays: wait until the topic `song` says that it has ended'
        return self._requests.refusal(oi.PlaySong)

    def _keep(self, command: oi.Command, reply: Reply, done: str) -> None:
        if self._requests.send(command, reply, done):
            self._lit[type(command)] = command


def _wrong_notes(pitches: Sequence[int], seconds: Sequence[float]) -> str:
    """Say what is wrong with the notes of a song that the command itself does not say."""
    if len(pitches) != len(seconds):
        return f'{len(pitches)} pitches but {len(seconds)} durations; give one for each note'
    for place, length in enumerate(seconds):
        if not 0 <= length <= LONGEST_NOTE:
            return f'seconds[{place}] = {length:g}; allowed: 0 to {LONGEST_NOTE:g}'
    return ''


def _rounding(seconds: Sequence[float]) -> str:
    """Say what rounding to 1/64 s does to durations."""
    lengths = [round(length * oi.NOTES_PER_SECOND) for length in seconds]
    played = sum(lengths) / oi.NOTES_PER_SECOND
    worst = max((abs(length / oi.NOTES_PER_SECOND - wanted)
                 for length, wanted in zip(lengths, seconds)), default=0.0)
    vanished = sum(1 for length, wanted in zip(lengths, seconds) if wanted > 0 == length)
    gone = f', {vanished} so short that they are left out' if vanished else ''
    if worst < 0.0005:
        return f'it takes {played:.3f} s'
    return (f'it takes {played:.3f} s, asked for {sum(seconds):.3f} s: notes are rounded to '
            f'1/64 s, by {worst * 1000:.0f} ms at most{gone}')
