"""
The command line: `python -m create_oi_ros.oi decode|encode|packets|commands`.

Made for the curious and for a pipe from a serial sniffer. `decode` explains bytes as they come;
what it prints can be read by `encode`. Of a driver's capture (`--capture FILE`) it tells what was
said when, in lines for people. The exit code is 0 when all was understood, 1 when something was
not, 2 for wrong usage.
"""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
import os
from pathlib import Path
import sys
from typing import TextIO

from ..commands import QueryList
from ..packets import PacketList
from ..readings import PACKETS
from .capture_format import CaptureError, CaptureReader, records_of
from .explain import decimal, explain_commands, explain_stream, octets, understood
from .tables import budget_lines, columns, commands_table, document, packets_table
from .text import parse_command, parse_commands
from .transcript import explain_capture

NOT_UNDERSTOOD = 1
BROKEN_PIPE = 128 + 13
INTERRUPTED = 128 + 2
AT_ONCE = 4096
"""Bytes."""


def _chunks(wanted: Namespace, stdin: TextIO) -> Iterator[bytes]:
    if wanted.bytes:
        yield octets(' '.join(wanted.bytes), hexadecimal=wanted.hex)
    elif wanted.raw:
        yield from iter(lambda: stdin.buffer.read1(AT_ONCE), b'')  # type: ignore[attr-defined]
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


def _capture(wanted: Namespace) -> Iterator[str]:
    reader = CaptureReader()
    with wanted.capture.open('rb') as file:
        records = records_of(iter(lambda: file.read(AT_ONCE), b''), reader)
        told = explain_capture(records, at_length=wanted.explain, everything=wanted.all)
        try:
            for number, line in enumerate(told):
                if number == 0 and reader.facts is not None:
                    yield from (f'{name} = {value}' for name, value in reader.facts.items())
                yield line
        except CaptureError as error:
            raise ValueError(f'{wanted.capture}: {error}') from error


def _decode(wanted: Namespace, stdin: TextIO) -> Iterator[str]:
    if wanted.capture:
        return _capture(wanted)
    chunks = _chunks(wanted, stdin)
    if wanted.stream:
        return explain_stream(chunks, map(_packet_list, wanted.stream))
    return explain_commands(chunks, at_length=wanted.explain)


def _encode(wanted: Namespace, stdin: TextIO) -> Iterator[str]:
    text = ' '.join(wanted.command) or stdin.read()
    for command in parse_commands(text):
        encoded = command.encode()
        yield encoded.hex(' ') if wanted.hex else decimal(encoded)


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
    door.add_argument('--capture', metavar='FILE', type=Path, help=(
        'explain a capture of a driver: what was said when, by host (->) and robot (<-)'))
    door.add_argument('--all', action='store_true', help=(
        'of a capture, every frame, not only what changes'))
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
            status = status if understood(line) else NOT_UNDERSTOOD
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

