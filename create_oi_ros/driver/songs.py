# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Songs and tunes: stored, played, stored again after the robot was switched off.

The robot reports which song plays, so a request to play one ends when it begins.

A tune has more notes than a song of the robot holds, and is played as songs that follow each
other. Two song numbers that nobody has defined are used in turn: while a song plays, the next is
stored. The robot ignores Play Song while a song plays (manual: Play Song), so the next one is
asked for in the frame in which packet 37 falls. No command ends a song: a tune that is canceled
ends with the song that plays.
"""

from collections.abc import Generator, Iterator, Sequence
from itertools import accumulate, chain, count, pairwise

from .. import oi
from ..oi.commands import NOTE_TIME
from ..robot import MILLI
from .core import Core
from .outbox import done, Pending, refused

SONGS, MAX_NOTES = 16, 16
"""How many songs the robot stores, and how many notes one of them holds (manual: Song)."""
SONG_TIMEOUT = 0.5
"""Seconds within which the robot must report a song that it was told to play."""
MIN_SEEN_LENGTH = 0.25
"""Seconds that a song must take to be in a frame at every usual rate."""
MAX_NOTE_LENGTH = NOTE_TIME.high / oi.NOTES_PER_SECOND
"""Seconds that a note can last."""
FOREVER = -1
"""Iterations of a tune that plays until it is canceled."""
NOT_REPORTED = 'was sent to play, but the robot does not report it: try again'
NO_ROOM = f'a tune needs two of the {SONGS} songs, and all are defined: define fewer'
WAIT = 'wait until the topic `song` says that it has ended'


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
        # As few songs as hold them, of the same size: none is too short to be seen.
        songs = -(-len(notes) // MAX_NOTES)
        bounds = [len(notes) * part // songs for part in range(songs + 1)]
        self.songs = [notes[low:high] for low, high in zip(bounds, bounds[1:])]

    def follow(self, song: int, since: float) -> None:
        """Find the note that sounds so many seconds after a song began."""
        ends = accumulate(note.duration / oi.NOTES_PER_SECOND for note in self.songs[song])
        sounds = min(sum(end <= since for end in ends), len(self.songs[song]) - 1)
        self.note = sum(map(len, self.songs[:song])) + sounds


class Songs:
    """The robot's songs, and what plays them."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self.defined: dict[int, oi.Song] = {}
        """The songs that were defined, by number."""
        self._now = 0.0
        self._player: Pending = done('no song')
        """A tune, or who waits for a single song to begin."""
        self._playing: Iterator[None] = iter(())
        """What is done for that, from poll to poll."""
        self._number = SONGS
        """Number of the song that was sent to play."""

    def define(self, number: int, pitches: Sequence[int], seconds: Sequence[float]) -> Pending:
        """Store a song: MIDI numbers, and durations in seconds, rounded to 1/64 s."""
        try:
            song = _song(number, pitches, seconds)
        except ValueError as error:
            return refused(str(error))
        request = self._core.request(song, _sent(number, seconds))
        if request.outcome is None:
            self.defined[number] = song
        return request

    def define_and_play(
        self, number: int, pitches: Sequence[int], seconds: Sequence[float], now: float,
    ) -> Pending:
        """Store a song and play it; nothing is stored where it could not be played."""
        why = self._cannot_play()
        stored = self.define(number, pitches, seconds) if why is None else refused(why)
        return stored if stored.outcome is not None else (
            self.play(number, now, f'{_sent(number, seconds)}; '))

    def play(self, number: int, now: float, stored: str = '') -> Pending:
        """
        Play a stored song, unless one plays; `stored` is what the outcome's text begins with.

        The request ends when the robot reports the song, or does not in time.
        """
        if number not in self.defined:
            known = ', '.join(map(str, sorted(self.defined))) or 'none yet'
            return refused(f'song {number} is not defined: call define_song; defined: {known}')
        why = self._cannot_play()
        if why is not None:
            return refused(why)
        if _seconds(self.defined[number].notes) < MIN_SEEN_LENGTH:
            return self._core.request(oi.PlaySong(number=number), (
                f'{stored}song {number} sent to play; it is too short to be seen playing'))
        request = Pending()
        self._begin(request, self._play_one(request, number, f'{stored}song {number} plays'), now)
        return request

    def play_tune(self, tune: Tune, now: float) -> None:
        """Play a tune; its outcome says how that ended, or why it cannot be played."""
        why = self._cannot_play()
        if why is not None:
            tune.end(False, why)
        else:
            self._begin(tune, self._play_all(tune), now)

    def _cannot_play(self) -> str | None:
        waits = self._player.outcome is None
        if waits and isinstance(self._player, Tune):
            return 'a tune plays: cancel its goal, or wait until that has ended'
        if self._core.readings.number('song_playing', 0):
            return f'a song plays: {WAIT}'
        if waits:
            return f'song {self._number} is about to play: {WAIT}'
        return self._core.refusal(oi.PlaySong)

    def _begin(self, player: Pending, playing: Iterator[None], now: float) -> None:
        self._player, self._playing, self._now = player, playing, now
        next(playing, None)

    def cancel(self, tune: Tune, why: str = 'canceled') -> None:
        """End a tune, if it goes on; the song that plays is heard to its end."""
        tune.end(False, f'{why}; the song that plays goes on to its end')

    def _play_one(self, request: Pending, number: int, text: str) -> Iterator[None]:
        """Send a song to play, and wait until the robot reports it."""
        begins = yield from self._begins(number)
        request.end(begins, text if begins else f'song {number} {NOT_REPORTED}')

    def _play_all(self, tune: Tune) -> Iterator[None]:
        """Play the songs of a tune; while one plays, the next is stored."""
        begun_at, number = self._now, self._store(tune.songs[0])
        rounds = count() if tune.iterations == FOREVER else range(tune.iterations)
        order = (song for _ in rounds for song in range(len(tune.songs)))
        for song, following in pairwise(chain(order, (None,))):
            assert song is not None
            if number in self.defined:  # somebody has defined it in the meantime
                number = self._store(tune.songs[song])
            refusal = self._core.refusal(oi.PlaySong)
            if number is None or refusal is not None:
                tune.end(False, NO_ROOM if number is None else
                         f'the tune ended before its end; {refusal}')
                return
            begins = yield from self._begins(number)
            if not begins and _seconds(tune.songs[song]) >= MIN_SEEN_LENGTH:
                tune.end(False, f'a song of the tune {NOT_REPORTED}')
                return
            since = self._now
            number = None if following is None else self._store(tune.songs[following])
            while begins and self._plays:
                tune.seconds = self._now - begun_at
                tune.follow(song, self._now - since)
                yield
            tune.iterations_played += song == len(tune.songs) - 1
        tune.end(True, 'the tune was played')

    def _store(self, notes: Sequence[oi.Note]) -> int | None:
        """Store a song where nobody has one; return its number, None where there is no room."""
        free = [number for number in range(SONGS)
                if number not in self.defined and number != self._number]
        if not free:
            return None
        self._core.outbox.send(oi.Song(number=free[-1], notes=tuple(notes)))
        return free[-1]

    def _begins(self, number: int) -> Generator[None, None, bool]:
        """Send a song to play; return whether the robot reports it in time."""
        self._core.outbox.send(oi.PlaySong(number=number))
        self._number, asked_at = number, self._now
        while self._now < asked_at + SONG_TIMEOUT:
            yield
            if self._plays:
                return True
        return False

    @property
    def _plays(self) -> bool:
        """Whether the robot reports the song that was sent to play, perhaps without its number."""
        readings = self._core.readings
        return bool(readings.number('song_playing', 0)) and (
            readings.number('song_number', self._number) == self._number)

    def restore(self) -> None:
        """Store the songs again: the robot may have been switched off."""
        for song in self.defined.values():
            self._core.outbox.send(song)

    def poll(self, now: float) -> None:
        """Go on with a song or a tune."""
        self._now = now
        if self._player.outcome is None:
            next(self._playing, None)

    def fail(self, why: str) -> None:
        """End a tune, and the request for a song that has not been reported."""
        self._player.end(False, why)


def _seconds(notes: Sequence[oi.Note]) -> float:
    return sum(note.duration for note in notes) / oi.NOTES_PER_SECOND


def _song(number: int, pitches: Sequence[int], seconds: Sequence[float]) -> oi.Song:
    """Make a song; ValueError says what is wrong that the command itself does not check."""
    if len(pitches) != len(seconds):
        raise ValueError(
            f'{len(pitches)} pitches but {len(seconds)} durations; give one for each note')
    if len(pitches) > MAX_NOTES:
        raise ValueError(f'{len(pitches)} notes, but a song holds {MAX_NOTES}: play more by the '
                         'action audio_note_sequence')
    for place, length in enumerate(seconds):
        if not 0 <= length <= MAX_NOTE_LENGTH:
            raise ValueError(f'seconds[{place}] = {length:g}; allowed: 0 to {MAX_NOTE_LENGTH:g}')
    lengths = [round(length * oi.NOTES_PER_SECOND) for length in seconds]
    return oi.Song(number=number, notes=tuple(oi.Note(*note) for note in zip(pitches, lengths)))


def _sent(number: int, seconds: Sequence[float]) -> str:
    """Say that a song was sent, and how rounding to 1/64 s changes its durations."""
    played = [round(length * oi.NOTES_PER_SECOND) / oi.NOTES_PER_SECOND for length in seconds]
    worst = max((abs(each - wanted) for each, wanted in zip(played, seconds)), default=0.0)
    text = f'song {number} sent; it takes {sum(played):.3f} s'
    if worst >= 0.0005:
        text += (f', asked for {sum(seconds):.3f} s: notes are rounded to 1/64 s, by '
                 f'{worst / MILLI:.0f} ms at most')
    return text
