# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The speaker: the host's sixteen songs, and the robot's own beep."""

from collections.abc import Sequence

from ...oi import Command, Note, NOTES_PER_SECOND, PlaySong, REST, Song, SOUNDING
from ..numbers import TOLERANCE

BEEP = (Note(84, 10),)
"""Sound of Start if the interface was off (manual: Start, 'beeps once'; the pitch is a guess)."""


class Speaker:
    """Plays one song or beep at a time. Times are seconds on the robot's clock."""

    __slots__ = ('songs', 'number', '_notes', '_begun', '_end', '_is_song')

    def __init__(self) -> None:
        self.songs: dict[int, tuple[Note, ...]] = {}
        self.number = 0
        """Packet 36: the song played last."""
        self._notes: Sequence[Note] = ()
        self._begun = self._end = 0.0
        self._is_song = False

    def execute(self, command: Command, time: float) -> None:
        """Carry out a command if it is for the speaker; its values are in range."""
        match command:
            case Song(number=number, notes=notes):
                self.songs[number] = notes
            case PlaySong(number=number) if number in self.songs and not self.song_playing(time):
                self.number = number
                self._begin(self.songs[number], time, is_song=True)

    def beep(self, time: float) -> None:
        """Beep as the robot itself does; a song that plays is not interrupted."""
        if not self.song_playing(time):
            self._begin(BEEP, time, is_song=False)

    def _begin(self, notes: Sequence[Note], time: float, *, is_song: bool) -> None:
        self._notes, self._is_song = notes, is_song
        self._begun = time
        self._end = time + sum(note.duration for note in notes) / NOTES_PER_SECOND

    def song_playing(self, time: float) -> bool:
        """Return whether a song plays (packet 37)."""
        return self._is_song and time < self._end - TOLERANCE

    def note(self, time: float) -> int:
        """Return the MIDI number of the note that sounds now; REST for silence."""
        if time >= self._end - TOLERANCE:
            return REST
        end = self._begun
        for note in self._notes:
            end += note.duration / NOTES_PER_SECOND
            if time < end - TOLERANCE:
                return note.number if note.number in SOUNDING else REST
        return REST
