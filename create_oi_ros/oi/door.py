"""
The command line: `python -m create_oi_ros.oi decode|encode|packets|commands`.

Made for the curious and for a pipe from a serial sniffer. `decode` explains bytes as they come,
a line for each command or frame; what it cannot explain it says behind a #, so that what it
prints can be read by `encode`. The exit code is 0 when all was understood, 1 when something was
not, 2 for wrong usage.
"""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Iterator
from enum import IntEnum, IntFlag
import os
from pathlib import Path
import re
import sys
from typing import Any, TextIO

from .command import Command
from .commands import QueryList
from .grammar import label
from .packets import PacketList, PACKETS
from .stream import Checksum, CommandReader, Frame, Garbage, StreamReader, UnknownOpcode
from .tables import budget_lines, columns, commands_table, document, packets_table
from .text import format_command, parse_command, parse_commands

SEPARATORS = re.compile(r'[\s,;:|\[\](){}]+')
CONVENTIONS = {
    Checksum.MANUAL: '# checksums leave the header out, as the manual says',
    Checksum.HARDWARE: '# checksums include the header, as real robots do',
}
NOT_UNDERSTOOD = 1
BROKEN_PIPE = 128 + 13
INTERRUPTED = 128 + 2


def octets(line: str, *, hexadecimal: bool = False) -> bytes:
    """
    Return the bytes that a line gives: decimal, with 0x or on request hexadecimal.

    Commas, brackets and the like are spaces; a # begins a comment. ValueError names the word
    that is no byte.
    """
    found = bytearray()
    for word in filter(None, SEPARATORS.split(line.partition('#')[0])):
        try:
            if hexadecimal or word[:2] in ('0x', '0X'):
                found += bytes.fromhex(word.removeprefix('0x').removeprefix('0X').zfill(2))
            else:
                found.append(int(word))
        except ValueError:
            raise ValueError(
                f'{word!r} is no byte: decimal 0 to 255, 0x00 to 0xff, or hexadecimal with --hex'
            ) from None
    return bytes(found)


def explain_commands(chunks: Iterable[bytes], *, at_length: bool = False) -> Iterator[str]:
    """Explain bytes that a host sent, a line for each command, as they come."""
    reader = CommandReader()
    for chunk in chunks:
        reader.feed(chunk)
        while (found := reader.next_event()) is not None:
            if isinstance(found, UnknownOpcode):
                yield f'# {found.data[0]} is the opcode of no command'
            else:
                yield _explained(found, at_length)
    if reader.pending:
        title = Command.by_opcode[reader.pending[0]].title
        yield f'# {title} is cut short: {_decimal(reader.pending)}'


def _explained(command: Command, at_length: bool) -> str:
    line = format_command(command)
    try:
        encoded = command.encode()
    except ValueError as refused:
        return f'# {line} (out of range: {refused})'
    if at_length:
        modes = ', '.join(mode.name.capitalize() for mode in sorted(command.modes))
        line += f'  # {_decimal(encoded)}. {command.__doc__} Obeyed in {modes}.'
    return line


def explain_stream(chunks: Iterable[bytes], lists: Iterable[PacketList]) -> Iterator[str]:
    """Explain bytes that a robot sent, a line for each frame, as they come."""
    reader = StreamReader(lists)
    convention: Checksum | None = None
    for chunk in chunks:
        reader.feed(chunk)
        while (found := reader.next_event()) is not None:
            if isinstance(found, Frame) and found.checksum is not convention:
                convention = found.checksum
                yield CONVENTIONS[convention]
            yield _frame(found) if isinstance(found, Frame) else _garbage(found)
    rest = reader.flush()
    if rest is not None:
        yield _garbage(rest)


def _frame(frame: Frame) -> str:
    values = vars(frame.readings)
    return ', '.join(
        f'{packet.title} = {_value(values[name])}{packet.wire.unit and f" {packet.wire.unit}"}'
        for packet, name in zip(frame.packets.packets, frame.packets.names))


def _value(value: Any) -> str:
    if isinstance(value, IntFlag):
        return '+'.join(label(bit) for bit in value) or '0'
    return label(value) if isinstance(value, IntEnum) else str(int(value))


def _garbage(garbage: Garbage) -> str:
    text = garbage.text
    return f'# garbage: {_decimal(garbage.data)}' + (f' {text!r}' if text else '')


def _decimal(data: bytes) -> str:
    return ' '.join(map(str, data))


def _chunks(wanted: Namespace, stdin: TextIO) -> Iterator[bytes]:
    if wanted.bytes:
        yield octets(' '.join(wanted.bytes), hexadecimal=wanted.hex)
    elif wanted.raw:
        yield from iter(lambda: stdin.buffer.read1(4096), b'')  # type: ignore[attr-defined]
    else:
        for number, line in enumerate(stdin, 1):
            try:
                yield octets(line, hexadecimal=wanted.hex)
            except ValueError as refused:
                raise ValueError(f'line {number}: {refused}') from None


def _packet_list(text: str) -> PacketList:
    command = parse_command(f'Query List packets={text}')
    assert isinstance(command, QueryList)
    return PacketList(command.packets)


def _decode(wanted: Namespace, stdin: TextIO) -> Iterator[str]:
    chunks = _chunks(wanted, stdin)
    if wanted.stream:
        return explain_stream(chunks, map(_packet_list, wanted.stream))
    return explain_commands(chunks, at_length=wanted.explain)


def _encode(wanted: Namespace, stdin: TextIO) -> Iterator[str]:
    text = ' '.join(wanted.command) or stdin.read()
    for command in parse_commands(text):
        encoded = command.encode()
        yield encoded.hex(' ') if wanted.hex else _decimal(encoded)


def _packets(wanted: Namespace, stdin: TextIO) -> Iterator[str]:
    if not wanted.ids:
        yield columns(packets_table()).rstrip()
        return
    packets = _packet_list(','.join(wanted.ids))
    numbers = {packet.id for packet in packets.packets}
    yield columns(packets_table(filter(numbers.__contains__, PACKETS))).rstrip()
    yield from budget_lines(packets)


def _commands(wanted: Namespace, stdin: TextIO) -> Iterator[str]:
    yield columns(commands_table()).rstrip()


def _document(wanted: Namespace, stdin: TextIO) -> Iterator[str]:
    before = wanted.page.read_text(encoding='utf-8')
    after = document(before)
    if wanted.check and before != after:
        raise ValueError(f'{wanted.page} is not what the declarations say; run without --check')
    if before != after:
        wanted.page.write_text(after, encoding='utf-8')
        yield f'{wanted.page} written'


def _parser() -> ArgumentParser:
    parser = ArgumentParser(
        prog='python -m create_oi_ros.oi',
        description='Explain and make bytes of the iRobot Create Open Interface.')
    doors = parser.add_subparsers(required=True, metavar='decode|encode|packets|commands')
    door = doors.add_parser('decode', help='explain bytes, given here or line by line on stdin')
    door.add_argument('bytes', nargs='*', help='decimal, or hexadecimal with 0x')
    door.add_argument('--hex', action='store_true', help='bytes are hexadecimal without 0x')
    door.add_argument('--raw', action='store_true', help='stdin brings the bytes themselves')
    door.add_argument('--explain', action='store_true', help='say what each command does')
    door.add_argument('--stream', metavar='IDS', action='append', help=(
        'the bytes are stream frames of these packets (29,13 or names); again for another list'))
    door.set_defaults(work=_decode)
    door = doors.add_parser('encode', help='turn commands, given here or on stdin, into bytes')
    door.add_argument('command', nargs='*', help="such as 'Drive velocity=-200 radius=500'")
    door.add_argument('--hex', action='store_true', help='write hexadecimal')
    door.set_defaults(work=_encode)
    door = doors.add_parser('packets', help='list the sensor packets')
    door.add_argument('ids', nargs='*', help='only these, and what streaming them costs')
    door.set_defaults(work=_packets)
    doors.add_parser('commands', help='list the commands').set_defaults(work=_commands)
    door = doors.add_parser('document', help='write the tables into a Markdown page')
    door.add_argument('page', type=Path)
    door.add_argument('--check', action='store_true', help='only tell whether they differ')
    door.set_defaults(work=_document)
    return parser


def main(arguments: list[str], stdin: TextIO, stdout: TextIO, stderr: TextIO) -> int:
    """Do what the arguments ask; return the exit code."""
    wanted = _parser().parse_args(arguments)
    status = 0
    try:
        for line in wanted.work(wanted, stdin):
            print(line, file=stdout, flush=True)
            if line.startswith('# ') and line not in CONVENTIONS.values():
                status = NOT_UNDERSTOOD
    except (ValueError, OSError) as refused:
        if isinstance(refused, BrokenPipeError):
            raise
        print(refused, file=stderr)
        status = NOT_UNDERSTOOD
    return status


def run() -> int:
    """Be the program: `main` on the real streams, quiet where a reader goes away."""
    try:
        return main(sys.argv[1:], sys.stdin, sys.stdout, sys.stderr)
    except BrokenPipeError:
        # Python flushes stdout once more at its end; let that go nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except KeyboardInterrupt:
        return INTERRUPTED
