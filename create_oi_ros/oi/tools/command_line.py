# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The command line: `python -m create_oi_ros.oi decode|encode|packets|commands`.

`decode` explains bytes, for example from a serial sniffer, line by line as they arrive; `encode`
reads what it prints. `decode --capture FILE` lists what a driver and its robot sent, with times.
The exit code is 0 if all bytes were understood, 1 if some were not, 2 for wrong usage.
"""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
import os
from pathlib import Path
import sys
from typing import TextIO

from ..packets import PacketList
from ..readings import PACKETS
from .capture_format import CaptureError, CaptureReader, records_of
from .explain import decimal, explain_commands, explain_replies, explain_stream, octets, understood
from .tables import budget_lines, columns, commands_table, packets_table
from .text import PACKET_NAMES, parse_commands, plain
from .transcript import explain_capture

NOT_UNDERSTOOD = 1
BROKEN_PIPE = 128 + 13
INTERRUPTED = 128 + 2
ANY = 'any'
"""In place of packets: those that the frames themselves name."""
CHUNK = 4096
"""Bytes that are read at once."""


def _chunks(options: Namespace, stdin: TextIO) -> Iterator[bytes]:
    if options.bytes:
        yield octets(' '.join(options.bytes), hexadecimal=options.hex)
    elif options.raw:
        yield from iter(lambda: stdin.buffer.read1(CHUNK), b'')  # type: ignore[attr-defined]
    else:
        for number, line in enumerate(stdin, 1):
            try:
                yield octets(line, hexadecimal=options.hex)
            except ValueError as refused:
                raise ValueError(f'line {number}: {refused}') from None


def _packet_list(text: str) -> PacketList:
    return PacketList(PACKET_NAMES.get(plain(word), int(word) if word.isdecimal() else word)
                      for word in map(str.strip, text.split(',')))


def _capture(options: Namespace) -> Iterator[str]:
    reader = CaptureReader()
    with options.capture.open('rb') as file:
        records = records_of(iter(lambda: file.read(CHUNK), b''), reader)
        lines = explain_capture(records, at_length=options.explain, everything=options.all)
        try:
            for number, line in enumerate(lines):
                if number == 0 and reader.facts is not None:
                    yield from (f'{name} = {value}' for name, value in reader.facts.items())
                yield line
        except CaptureError as error:
            raise ValueError(f'{options.capture}: {error}') from error


def _decode(options: Namespace, stdin: TextIO) -> Iterator[str]:
    if options.capture:
        return _capture(options)
    chunks = _chunks(options, stdin)
    if options.stream:
        return explain_stream(
            chunks, [] if options.stream == [ANY] else list(map(_packet_list, options.stream)))
    if options.reply:
        return explain_replies(chunks, _packet_list(options.reply))
    return explain_commands(chunks, at_length=options.explain)


def _encode(options: Namespace, stdin: TextIO) -> Iterator[str]:
    text = ' '.join(options.command) or stdin.read()
    for command in parse_commands(text):
        encoded = command.encode()
        yield encoded.hex(' ') if options.hex else decimal(encoded)


def _packets(options: Namespace, stdin: TextIO) -> Iterator[str]:
    if not options.ids:
        yield columns(packets_table()).rstrip()
        return
    packets = _packet_list(','.join(options.ids))
    numbers = {packet.id for packet in packets.packets}
    yield columns(packets_table(filter(numbers.__contains__, PACKETS))).rstrip()
    yield from budget_lines(packets)


def _commands(options: Namespace, stdin: TextIO) -> Iterator[str]:
    yield columns(commands_table()).rstrip()


def _parser() -> ArgumentParser:
    parser = ArgumentParser(
        prog='python -m create_oi_ros.oi',
        description='Explain and encode bytes of the iRobot Create Open Interface.')
    actions = parser.add_subparsers(required=True, metavar='decode|encode|packets|commands')
    _add_decode(actions.add_parser(
        'decode', help='explain bytes, given here or line by line on stdin'))
    encode = actions.add_parser('encode', help='turn commands, given here or on stdin, into bytes')
    encode.add_argument('command', nargs='*', help="such as 'Drive velocity=-200 radius=500'")
    encode.add_argument('--hex', action='store_true', help='write hexadecimal')
    encode.set_defaults(work=_encode)
    packets = actions.add_parser('packets', help='list the sensor packets')
    packets.add_argument('ids', nargs='*', help='list only these, and what streaming them costs')
    packets.set_defaults(work=_packets)
    actions.add_parser('commands', help='list the commands').set_defaults(work=_commands)
    return parser


def _add_decode(decode: ArgumentParser) -> None:
    decode.add_argument('bytes', nargs='*', help='decimal, or hexadecimal with 0x')
    decode.add_argument('--hex', action='store_true', help='bytes are hexadecimal without 0x')
    decode.add_argument('--raw', action='store_true', help='stdin is binary, not text')
    decode.add_argument('--explain', action='store_true', help='say what each command does')
    decode.add_argument('--stream', metavar='IDS', action='append', help=(
        'the bytes are stream frames of these packets (29,13 or names); repeat for more lists; '
        'any: of those that the frames themselves name'))
    decode.add_argument('--reply', metavar='IDS', help=(
        'the bytes are replies to Sensors or Query List with these packets (0, or 29,13)'))
    decode.add_argument('--capture', metavar='FILE', type=Path, help=(
        'explain a capture of a driver: what host (->) and robot (<-) sent, and when'))
    decode.add_argument('--all', action='store_true', help=(
        'show every frame of a capture, not only changes'))
    decode.set_defaults(work=_decode)


def main(arguments: list[str], stdin: TextIO, stdout: TextIO, stderr: TextIO) -> int:
    """Run the command line; return the exit code."""
    options = _parser().parse_args(arguments)
    status = 0
    try:
        for line in options.work(options, stdin):
            print(line, file=stdout, flush=True)
            status = status if understood(line) else NOT_UNDERSTOOD
    except BrokenPipeError:
        raise
    except OSError as error:
        print(f'{error.filename}: {error.strerror}: give a file that can be read', file=stderr)
        status = NOT_UNDERSTOOD
    except ValueError as refused:
        print(refused, file=stderr)
        status = NOT_UNDERSTOOD
    return status


def run() -> int:
    """Run `main` on the process's own streams; end quietly when the reader of stdout ends."""
    try:
        return main(sys.argv[1:], sys.stdin, sys.stdout, sys.stderr)
    except BrokenPipeError:
        # Python flushes stdout at exit, which would fail again: send that to the null device.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except KeyboardInterrupt:
        return INTERRUPTED
