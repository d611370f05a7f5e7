# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Tunes: more notes than a song of the robot holds, played as songs that follow each other.

Two song numbers that nobody has defined are used in turn: while a song plays, the next is stored.
The robot ignores Play Song while a song plays (manual: Play Song), so the next one is asked for in
the frame in which packet 37 falls. No command ends a song: a tune that is canceled ends with the
song that plays.
"""

from collections.abc import Callable, Container, Sequence
from itertools import accumulate

from .. import oi
from .core import Core
from .outbox import Pending

SONGS, MOST_NOTES = 16, 16
"""How many songs the robot stores, and how many notes one of them holds (manual: Song)."""
SONG_TIMEOUT = 0.5
"""Seconds within which the robot must report a song that it was told to play."""
SHORTEST_SEEN = 0.25
"""Seconds that a song must take to be in a frame at every usual rate."""

FOREVER = -1
"""Iterations of a tune that plays until it is canceled."""


class Tune(Pending):
    """A tune that was given to the driver, and how far it is."""

    def __init__(self, notes: Sequence[oi.Note], iterations: int = 1) -> None:
        """Play notes so many times, or `FOREVER`."""
        super().__init__()
        self.notes = notes
        self.iterations = iterations
        self.iterations_played = 0
        self.note = -1
        """Place in the tune of the note that sounds; -1 before the first."""
        self.seconds = 0.0
        """How long it has played."""
        self.songs = songs_of(notes)
        self.song = 0
        """Which of its songs plays."""

    @property
    def length(self) -> float:
        """Seconds that the song takes."""
        return sum(note.duration for note in self.songs[self.song]) / oi.NOTES_PER_SECOND

    @property
    def next_song(self) -> int | None:
        """Which song comes after the one that plays; None: no more."""
        if self.song + 1 < len(self.songs):
            return self.song + 1
        return 0 if self.iterations_played + 1 != self.iterations else None

    def follow(self, since: float) -> None:
        """Find the note that sounds so many seconds after the song began."""
        before = sum(map(len, self.songs[:self.song]))
        ends = accumulate(note.duration / oi.NOTES_PER_SECOND for note in self.songs[self.song])
        self.note = min(before + sum(end <= since for end in ends),
                        before + len(self.songs[self.song]) - 1)


def songs_of(notes: Sequence[oi.Note]) -> list[Sequence[oi.Note]]:
    """Cut notes into as few songs as hold them, of the same size: none is too short to be seen."""
    count = -(-len(notes) // MOST_NOTES)
    bounds = [len(notes) * part // count for part in range(count + 1)]
    return [notes[low:high] for low, high in zip(bounds, bounds[1:])]


class Tunes:
    """Plays one tune at a time, beside whatever the wheels do."""

    def __init__(
        self, core: Core, defined: Container[int], refusal: Callable[[], str | None],
    ) -> None:
        """Use no song that is `defined`; `refusal` says why none can be played now."""
        self._core = core
        self._defined = defined
        self._refusal = refusal
        self.tune: Tune | None = None
        """The tune that plays."""
        self._stored = self._playing = SONGS
        """Numbers of the song that is stored to be played, and of the one that plays."""
        self._started_at = self._asked_at = 0.0
        self._begun_at: float | None = None
        """When the robot reported the song; None before that."""

    def start(self, tune: Tune, now: float) -> None:
        """Play a tune; its outcome says how that ended, or why it cannot be played."""
        why = self._refusal()
        if why is not None:
            tune.end(False, why)
            return
        self.tune, self._started_at, self._playing = tune, now, SONGS
        if self._store(tune, 0):
            self._ask(tune, now)

    def cancel(self, tune: Tune, why: str = 'canceled') -> None:
        """End a tune, if it still plays; the song that plays is heard to its end."""
        if tune is self.tune:
            self.fail(f'{why}; the song that plays goes on to its end')

    def fail(self, why: str) -> None:
        """End the tune, if one plays."""
        tune, self.tune = self.tune, None
        if tune is not None:
            tune.end(False, why)

    def observe(self, readings: oi.Readings, now: float) -> None:
        """Go on to the next song where one has ended; called in every frame."""
        tune = self.tune
        if tune is None:
            return
        tune.seconds = now - self._started_at
        ours = readings.song_playing and readings.song_number in (self._playing, None)
        if self._begun_at is None and ours:
            self._begun_at = now
            if tune.next_song is not None:
                self._store(tune, tune.next_song)
        elif self._begun_at is not None and not ours:
            self._next(tune, now)
        if self._begun_at is not None:
            tune.follow(now - self._begun_at)

    def check_timeout(self, now: float) -> None:
        """Go on after a song that was too short to be seen; end a tune that is not played."""
        tune = self.tune
        if tune is None or self._begun_at is not None or now < self._asked_at + SONG_TIMEOUT:
            return
        if tune.length < SHORTEST_SEEN:
            self._next(tune, now)
        else:
            self.fail('a song of the tune was sent to play, but the robot does not report it: '
                      'try again')

    def _store(self, tune: Tune, song: int) -> bool:
        """Store a song where nobody has one; end the tune where there is no room."""
        free = [number for number in range(SONGS)
                if number not in self._defined and number != self._playing]
        if not free:
            self.fail(f'a tune needs two of the {SONGS} songs, and all are defined: define fewer')
            return False
        self._stored = free[-1]
        self._core.outbox.send(oi.Song(
            number=self._stored, notes=tuple(tune.songs[song])))
        return True

    def _next(self, tune: Tune, now: float) -> None:
        """Play the next song; end the tune after its last."""
        following = tune.next_song
        if following is None or following == 0:
            tune.iterations_played += 1
        if following is None:
            self.tune = None
            tune.end(True, 'the tune was played')
            return
        tune.song = following
        # Somebody may have defined this song in the meantime.
        if self._stored not in self._defined or self._store(tune, following):
            self._ask(tune, now)

    def _ask(self, tune: Tune, now: float) -> None:
        """Ask for the song that is stored."""
        why = self._core.refusal(oi.PlaySong)
        if why is not None:
            self.fail(f'the tune ended before its end; {why}')
            return
        self._core.outbox.send(oi.PlaySong(number=self._stored))
        self._playing, self._begun_at, self._asked_at = self._stored, None, now
