"""The speaker: sixteen songs of the host's, and the robot's own beeps and tunes."""

from __future__ import annotations

from collections.abc import Sequence

from ...oi import Command, Note, NOTES_PER_SECOND, PlaySong, REST, Song, SOUNDING

BEEP = (Note(84, 10),)
"""What Start sounds like when the interface was off (manual: Start, 'beeps once'; pitch guess)."""
DESCENDING = tuple(Note(number, 12) for number in (84, 79, 76, 72))
"""The tune that tells of 19200 baud (manual: Serial Port Settings, 'descending pitches')."""
EARLY = 1e-6


class Speaker:
    """Times are seconds on the robot's clock."""

    __slots__ = ('songs', 'number', '_notes', '_begun', '_end', '_is_song')

    def __init__(self) -> None:
        self.songs: dict[int, tuple[Note, ...]] = {}
        self.number = 0
        """Packet 36: the song that was played last."""
        self._notes: Sequence[Note] = ()
        self._begun = self._end = 0.0
        self._is_song = False

    def obey(self, command: Command, time: float) -> None:
        """Do what a command says that is in range; others are not for the speaker."""
        match command:
            case Song(number=number, notes=notes):
                self.songs[number] = notes
            case PlaySong(number=number):
                self.play(number, time)

    def play(self, number: int, time: float) -> bool:
        """Play a stored song; False: there is none, or one plays already."""
        if number not in self.songs or self.song_playing(time):
            return False
        self.number = number
        self._begin(self.songs[number], time, is_song=True)
        return True

    def sound(self, notes: Sequence[Note], time: float) -> None:
        """Let the robot itself be heard, unless a song plays: that is not cut short."""
        if not self.song_playing(time):
            self._begin(notes, time, is_song=False)

    def _begin(self, notes: Sequence[Note], time: float, *, is_song: bool) -> None:
        self._notes, self._is_song = notes, is_song
        self._begun = time
        self._end = time + sum(note.duration for note in notes) / NOTES_PER_SECOND

    def song_playing(self, time: float) -> bool:
        """Packet 37."""
        return self._is_song and time < self._end - EARLY

    def note(self, time: float) -> int:
        """Return the MIDI number of the note that sounds now; REST when all is quiet."""
        if time >= self._end - EARLY:
            return REST
        end = self._begun
        for note in self._notes:
            end += note.duration / NOTES_PER_SECOND
            if time < end - EARLY:
                return note.number if note.number in SOUNDING else REST
        return REST

    def hush(self) -> None:
        """Stop at once."""
        self._notes, self._end, self._is_song = (), 0.0, False
