# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The declarations as tables, for a terminal and for docs/open_interface.md."""

from collections.abc import Iterable, Sequence

from ...robot import MILLI, SLOT
from ..codes import START_BAUDS
from ..commands import COMMANDS
from ..declaration import Command
from ..packets import PacketList
from ..readings import NAMES, PACKETS
from ..wire import Wire

Row = Sequence[str]
FORMATS = {'b': 'signed byte', 'B': 'byte', 'h': 'signed word', 'H': 'word'}
"""A word is two bytes, high byte first."""


def commands_table() -> list[Row]:
    """Return the table of commands."""
    rows: list[Row] = [('Opcode', 'Command', 'Data', 'Obeyed from', 'Enters')]
    for kind in COMMANDS:
        enters = kind.enters.name.capitalize() if kind.enters is not None else ''
        lowest = min(kind.modes).name.capitalize()
        rows.append((str(kind.opcode), kind.title, _payload(kind), lowest, enters))
    return rows


def _payload(kind: type[Command]) -> str:
    parts = [f'{name}: {_described(wire)}' for name, wire in kind.fields]
    if kind.tail is not None:
        name, counted, _ = kind.tail
        items = ' and '.join(_described(wire) for wire in counted.item)
        parts.append(f'{name}: {counted.describe()}, a byte for their number, each {items}')
    return '; '.join(parts)


def _described(wire: Wire) -> str:
    bytes_ = FORMATS[wire.format]
    if (wire.low, wire.high) == wire.limits:
        return f'{bytes_} ({wire.unit})' if wire.unit else bytes_
    return f'{bytes_}, {wire.describe()}'


def packets_table(ids: Iterable[int] = PACKETS) -> list[Row]:
    """Return the table of single packets, or of some of them."""
    rows: list[Row] = [('Packet', 'Field', 'Value')]
    rows += [(str(number), NAMES[number], _described(PACKETS[number].wire)) for number in ids]
    return rows


def budget_lines(packets: PacketList) -> list[str]:
    """Say what streaming a list costs at the baud rates that the robot can start with."""
    lines = []
    for baud in START_BAUDS:
        budget = packets.budget(baud)
        verdict = f'{budget.spare} to spare' if budget.fits else f'{-budget.spare} too many'
        lines.append(
            f'{baud} baud: a stream frame has {budget.size} bytes and takes '
            f'{budget.seconds / MILLI:.1f} ms; {budget.capacity} fit in {SLOT / MILLI:.0f} ms: '
            f'{verdict}')
    return lines


def columns(rows: Sequence[Row]) -> str:
    """Return a table for a terminal."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    return ''.join(
        '  '.join(map(str.ljust, row, widths)).rstrip() + '\n' for row in rows)
