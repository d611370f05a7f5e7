# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Explains a capture in the manual's words: one line for what host or robot sent, with its time.

The Stream commands in the capture say which packets the frames contain. Most frames repeat the
frame before, so only changes are shown, and a summary every ten seconds. Commands that repeat
the same speeds or request the same packets are only counted.
"""

from collections import Counter
from collections.abc import Iterable, Iterator

from ..commands import Drive, DriveDirect, Stream
from ..declaration import Command
from ..packets import PACKET_IDS, PacketList
from ..readings import NUMBERS, PACKETS
from ..stream import Checksum, CommandReader, Frame, Garbage, StreamReader, UnknownOpcode
from .capture_format import MICROSECONDS, Record, RecordKind
from .explain import CONVENTIONS, decimal, explain_command, explain_reading, explain_readings

SUMMARY_INTERVAL = 10 * MICROSECONDS
SILENCE = MICROSECONDS // 4
"""A longer pause of the robot is shown."""
BYTES_SHOWN = 24
GARBAGE_SHOWN = 5
"""Pieces of garbage that are shown until the next summary."""
IDEMPOTENT = (Drive, DriveDirect, Stream)
"""Commands that change nothing when they are repeated."""
FROM_ROBOT, TO_ROBOT, OTHER = '<-', '->', '--'
WORDS = {
    RecordKind.OPENED: 'port opened: ', RecordKind.LOST: 'port lost: ',
    RecordKind.BAUD: 'host speaks at baud rate ',
    RecordKind.NOTE: 'driver says ', RecordKind.END: 'end of the capture',
}
SHOWN_READINGS = {
    name: PACKETS[number] for name, number in NUMBERS.items()
    if PACKETS[number].wire.format == 'B' or PACKETS[number].wire.unit == 'mm/s'}
"""Readings that change only when something happens: not signals, voltages, distances."""


class Summary:
    """Counts what is not shown line by line."""

    def __init__(self, since: int) -> None:
        """Start at a time in microseconds."""
        self.since = since
        self.frames = 0
        self.totals: Counter[str] = Counter()
        self.voltage: int | None = None
        self.garbage = self.garbage_bytes = 0
        self.repeated: Counter[str] = Counter()

    def add(self, frame: Frame) -> None:
        """Count a frame and add up its distance and angle."""
        values = dict(frame.readings.items())
        self.frames += 1
        for name in ('distance', 'angle'):
            if name in values:
                self.totals[name] += values[name]
        self.voltage = values.get('voltage', self.voltage)

    def text(self, now: int) -> str:
        """Return the summary as text; '' if nothing was counted."""
        parts = []
        if self.frames:
            parts.append(f'{self.frames} frames in {(now - self.since) / MICROSECONDS:.1f} s')
            parts += [explain_reading(PACKETS[NUMBERS[name]], total)
                      for name, total in self.totals.items()]
        if self.voltage is not None:
            parts.append(explain_reading(PACKETS[NUMBERS['voltage']], self.voltage))
        if self.garbage:
            parts.append(f'{self.garbage} pieces of garbage ({self.garbage_bytes} bytes)')
        parts += [f'{title} sent again {count} times' for title, count in self.repeated.items()]
        return ', '.join(parts)


class Transcript:
    """Explains records one after the other; `everything` also shows what repeats."""

    def __init__(self, *, at_length: bool = False, everything: bool = False) -> None:
        self._at_length, self._everything = at_length, everything
        self._robot, self._host = StreamReader(), CommandReader()
        self._lists: set[PacketList] = set()
        self._checksum: Checksum | None = None
        self._failures = 0
        self._summary = Summary(0)
        self._now = 0
        self._restart()

    def _restart(self) -> None:
        """Forget what was shown: after the port has been opened, everything is news."""
        self._shown_values: dict[str, object] = {}
        self._sent: dict[type[Command], list[Command]] = {}
        self._heard_at: int | None = None

    def lines(self, record: Record) -> Iterator[str]:
        """Explain a record."""
        if record.time - self._summary.since > SUMMARY_INTERVAL:
            yield from self._summarize()
        self._now = record.time
        match record.kind:
            case RecordKind.FROM_ROBOT:
                yield from self._from_robot(record)
            case RecordKind.TO_ROBOT:
                self._host.feed(record.data)
                yield from self._commands()
            case _:
                if record.kind is not RecordKind.NOTE:
                    yield from self.finish()
                if record.kind is RecordKind.OPENED:
                    self._restart()
                yield self._line(OTHER, WORDS[record.kind] + record.text)

    def finish(self) -> Iterator[str]:
        """Explain what is left after the last record."""
        for event in self._robot.finish():
            yield from self._event(event)
        if self._host.pending:
            title = Command.by_opcode[self._host.pending[0]].title
            yield self._line(
                TO_ROBOT, f'{title} is cut short: {self._decimal(self._host.clear())}')
        yield from self._summarize()

    def _from_robot(self, record: Record) -> Iterator[str]:
        before, self._heard_at = self._heard_at, record.time
        silence = 0 if before is None else record.time - before
        if silence > SILENCE:
            yield self._line(OTHER, f'silence of the robot, {silence / MICROSECONDS:.3f} s')
        self._robot.feed(record.data)
        for event in self._robot:
            yield from self._event(event)

    def _line(self, direction: str, text: str) -> str:
        return f'{self._now / MICROSECONDS:11.3f} {direction} {text}'

    def _summarize(self) -> Iterator[str]:
        text = self._summary.text(self._now)
        if text:
            yield self._line(OTHER, text)
        self._summary = Summary(self._now)

    def _event(self, event: Frame | Garbage) -> Iterator[str]:
        if isinstance(event, Garbage):
            yield from self._garbage(event)
            return
        if event.checksum is not self._checksum:
            self._checksum = event.checksum
            yield self._line(OTHER, CONVENTIONS[event.checksum].removeprefix('# '))
        if self._everything:
            yield self._line(FROM_ROBOT, explain_readings(event.packets, event.readings))
            return
        self._summary.add(event)
        news = {name: value for name, value in event.readings.items()
                if name in SHOWN_READINGS and self._shown_values.get(name) != value}
        if news:
            self._shown_values.update(news)
            yield self._line(FROM_ROBOT, ', '.join(
                explain_reading(SHOWN_READINGS[name], value) for name, value in news.items()))

    def _garbage(self, garbage: Garbage) -> Iterator[str]:
        self._summary.garbage += 1
        self._summary.garbage_bytes += len(garbage.data)
        failures, self._failures = self._failures, self._robot.checksum_failures
        what = 'checksum is wrong' if self._failures > failures else 'no frame'
        if self._summary.garbage <= GARBAGE_SHOWN or garbage.text or self._everything:
            text = f' {garbage.text!r}' if garbage.text else ''
            yield self._line(FROM_ROBOT, f'{what}: {self._decimal(garbage.data)}{text}')

    def _commands(self) -> Iterator[str]:
        unknown = bytearray()
        for found in self._host:
            if isinstance(found, UnknownOpcode):
                unknown += found.data
                continue
            yield from self._unknown(unknown)
            unknown.clear()
            if isinstance(found, Stream) and set(found.packets) <= set(PACKET_IDS):
                self._lists.add(PacketList(found.packets))
                self._robot.expect(self._lists)
            if self._is_new(found) or self._everything:
                yield self._line(TO_ROBOT, explain_command(found, at_length=self._at_length))
            else:
                self._summary.repeated[found.title] += 1
        yield from self._unknown(unknown)

    def _unknown(self, data: bytes | bytearray) -> Iterator[str]:
        if data:
            yield self._line(TO_ROBOT, f'no command: {self._decimal(bytes(data))}')

    def _is_new(self, command: Command) -> bool:
        if not isinstance(command, IDEMPOTENT):
            return True
        if command in self._sent.setdefault(type(command), []):
            return False
        if not isinstance(command, Stream):
            for kind in (Drive, DriveDirect):
                self._sent[kind] = []
        self._sent[type(command)].append(command)
        return True

    def _decimal(self, data: bytes) -> str:
        if len(data) <= BYTES_SHOWN or self._everything:
            return decimal(data)
        return f'{decimal(data[:BYTES_SHOWN])} ... ({len(data)} bytes)'


def explain_capture(
    records: Iterable[Record], *, at_length: bool = False, everything: bool = False,
) -> Iterator[str]:
    """Explain records as they arrive; an error in them is raised after all lines before it."""
    transcript = Transcript(at_length=at_length, everything=everything)
    try:
        for record in records:
            yield from transcript.lines(record)
    except ValueError:
        yield from transcript.finish()
        raise
