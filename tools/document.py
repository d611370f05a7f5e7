# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Writes what follows from declarations and measurements into the documents: `make docs`.

`python tools/document.py FILE ...` writes a .yaml file as a whole: the parameters with their
defaults. In any other file it replaces the blocks between two comments, `<!-- LABEL -->` and
`<!-- end -->`: tables of the ROS interface and of the Open Interface, names in the SROS 2 policy,
and the figures of a bench in `bench/results.json`.
"""

from collections.abc import Callable, Iterable
from dataclasses import fields
from enum import IntEnum, IntFlag
from functools import partial
import json
from pathlib import Path
import re
import sys
from textwrap import wrap

from create_oi_ros.oi.commands import COMMANDS
from create_oi_ros.oi.packets import GROUPS, size_of
from create_oi_ros.oi.readings import PACKETS
from create_oi_ros.oi.tools.tables import commands_table, packets_table, Row
from create_oi_ros.ros.actions import ACTIONS
from create_oi_ros.ros.parameters import allowed, Parameters, shown
from create_oi_ros.ros.services import SERVICES
from create_oi_ros.ros.topics import ALL_TOPICS, type_name
from results import figures_of, load
from results import rows as rows_of

CONFIG_WIDTH = 93
"""Characters of a comment line at most."""
POLICY_INDENT = 12 * ' '


def table(heading: Row, rows: Iterable[Row]) -> str:
    """Return a Markdown table, with a line end after each row."""
    lines = [heading, ['---'] * len(heading), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


# The ROS interface.


def topics() -> str:
    return table(('topic', 'type', 'when', 'what'), (
        (f'`{topic.name}`', type_name(topic.type), topic.when, topic.about)
        for topic in ALL_TOPICS))


def services() -> str:
    return table(('service', 'type', 'what'), (
        (f'`{service.name}`', type_name(service.type), service.about) for service in SERVICES))


def actions() -> str:
    return table(('action', 'type', 'goal', 'what'), (
        (f'`{action.name}`', type_name(action.type),
         ', '.join(f'`{name}`' for name in action.type.Goal.get_fields_and_field_types()),
         action.about) for action in ACTIONS))


def parameters() -> str:
    rows = []
    for declared in fields(Parameters):
        facts = declared.metadata
        rows.append((
            f'`{declared.name}`', f'`{shown(declared.default)}`', allowed(facts),
            'any time' if facts['live'] else 'at start', facts['description']))
    return table(('parameter', 'default', 'allowed', 'set', 'what'), rows)


def policy_names(element: str, names: Iterable[str]) -> str:
    """Return names as elements of an SROS 2 policy."""
    return ''.join(f'{POLICY_INDENT}<{element}>{name}</{element}>\n' for name in names) \
        + POLICY_INDENT


CONFIG_HEAD = (
    '# Every parameter of create_node with its default; made by `make docs`. Copy it, change it:\n'
    '# ros2 run create_oi_ros create_node --ros-args --params-file my_create.yaml\n'
    '/**:\n'
    '  ros__parameters:\n')


def config() -> str:
    """Return a parameter file with all defaults."""
    lines = []
    for declared in fields(Parameters):
        about, values = declared.metadata['description'], allowed(declared.metadata)
        about += f' ({values})' if values else ''
        lines += [f'    # {line}' for line in wrap(about, CONFIG_WIDTH)]
        lines.append(f'    {declared.name}: {json.dumps(declared.default)}')
    return CONFIG_HEAD + '\n'.join(lines) + '\n'


# The Open Interface.


def groups_table() -> list[Row]:
    """Return the table of groups."""
    return [('Group', 'Bytes', 'Contains packets'), *(
        (str(number), str(size_of(number)), f'{members[0]} - {members[-1]}')
        for number, members in GROUPS.items())]


def codes_table() -> list[Row]:
    """Return the table of named numbers in commands and packets; the other tables have bits."""
    used: dict[type[IntEnum] | type[IntFlag], list[str]] = {}
    wires = [(kind.title, field.wire) for kind in COMMANDS for field in kind.fields]
    for title, wire in wires + [(packet.title, packet.wire) for packet in PACKETS.values()]:
        if wire.names is not None and not wire.mask:
            used.setdefault(wire.names, []).append(title)
    rows: list[Row] = [('Names', 'Used in', 'Numbers')]
    for names, titles in used.items():
        numbers = ', '.join(f'{member.value} {member.name}' for member in names)
        rows.append((names.__name__, ', '.join(titles), numbers))
    return rows


def framed(rows: Callable[[], list[Row]]) -> str:
    """Return a table between empty lines."""
    heading, *others = rows()
    return f'\n{table(heading, others)}\n'


# The measurements.


BENCH, MEASURED = 'bench', 'measured'
"""Labels of tables with and without the targets."""


def figures(label: str) -> str:
    """Return a program's figures in Markdown; with `measured` before it, without targets."""
    results, (kind, program) = load(), label.split()
    where = results[program]['where']
    chosen = figures_of(results, program)
    if kind == MEASURED:
        chosen = [each._replace(target=None) for each in chosen]
    heading, *body = rows_of(chosen)
    missed = any(each.missed for each in chosen)
    return (f'{table(heading, body)}\n'
            f'`{program}` on {where["date"][:10]}: {where["processor"]}, '
            f'{where["cores"]} cores, load {where["load before"]} before, '
            f'Python {where["python"]}.{" Targets in bold were missed." if missed else ""}\n')


# The documents.


TABLES: dict[str, Callable[[], str]] = {
    'topics': topics, 'services': services, 'actions': actions, 'parameters': parameters}
POLICY: dict[str, Callable[[], str]] = {
    'all topics': lambda: policy_names('topic', (topic.name for topic in ALL_TOPICS)),
    'all actions': lambda: policy_names('action', (action.name for action in ACTIONS)),
    'all services': lambda: policy_names('service', (service.name for service in SERVICES))}
OPEN_INTERFACE: dict[str, Callable[[], str]] = {
    'table: commands': partial(framed, commands_table),
    'table: packets': partial(framed, packets_table),
    'table: groups': partial(framed, groups_table), 'table: codes': partial(framed, codes_table)}
BLOCKS = {**TABLES, **POLICY, **OPEN_INTERFACE}
BLOCK = re.compile(
    rf'(?P<start><!-- (?P<label>{"|".join(BLOCKS)}|{BENCH} \w+|{MEASURED} \w+) -->\n)'
    r'.*?(?P<end><!-- end -->)', re.DOTALL)


def rewritten(text: str) -> str:
    """Return a file with its generated blocks made again."""
    def block(found: re.Match[str]) -> str:
        label = found['label']
        made = BLOCKS[label]() if label in BLOCKS else figures(label)
        return found['start'] + made + found['end']
    return BLOCK.sub(block, text)


if __name__ == '__main__':
    for path in map(Path, sys.argv[1:]):
        path.write_text(config() if path.suffix == '.yaml' else rewritten(path.read_text('utf-8')),
                        'utf-8')
