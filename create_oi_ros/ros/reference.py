# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Writes what follows from the declarations of topics, services, actions and parameters: `make docs`.

`python -m create_oi_ros.ros.reference FILE ...` writes a .yaml file as a whole: the parameters
with their defaults. In any other file it replaces the blocks between their markers: the tables of
docs/interface.md, and the names in config/sros2_policy.xml.
"""

from collections.abc import Iterable
from dataclasses import fields
import json
from pathlib import Path
import sys
from textwrap import wrap

from ..oi.tools import markdown
from .actions import ALL_ACTIONS
from .parameters import allowed, Parameters, shown
from .services import SERVICES
from .topics import ALL_TOPICS, type_name

CONFIG_WIDTH = 93
"""Characters of a comment line at most."""
POLICY_INDENT = 12 * ' '


def topics() -> str:
    return markdown.table(('topic', 'type', 'when', 'what'), (
        (f'`{topic.name}`', type_name(topic.type), topic.when, topic.about)
        for topic in ALL_TOPICS))


def services() -> str:
    return markdown.table(('service', 'type', 'what'), (
        (f'`{service.name}`', type_name(service.type), service.about) for service in SERVICES))


def actions() -> str:
    return markdown.table(('action', 'type', 'goal', 'what'), (
        (f'`{action.name}`', type_name(action.type),
         ', '.join(f'`{name}`' for name in action.type.Goal.get_fields_and_field_types()),
         action.about) for action in ALL_ACTIONS))


def parameters() -> str:
    rows = []
    for declared in fields(Parameters):
        facts = declared.metadata
        rows.append((
            f'`{declared.name}`', f'`{shown(declared.default)}`', allowed(facts),
            'any time' if facts['live'] else 'at start', facts['description']))
    return markdown.table(('parameter', 'default', 'allowed', 'set', 'what'), rows)


def policy_names(element: str, names: Iterable[str]) -> str:
    """Return names as elements of an SROS 2 policy."""
    return ''.join(f'{POLICY_INDENT}<{element}>{name}</{element}>\n' for name in names) \
        + POLICY_INDENT


TABLES = {'topics': topics, 'services': services, 'actions': actions, 'parameters': parameters}
POLICY = {
    'all topics': lambda: policy_names('topic', (topic.name for topic in ALL_TOPICS)),
    'all actions': lambda: policy_names('action', (action.name for action in ALL_ACTIONS)),
    'all services': lambda: policy_names('service', (service.name for service in SERVICES)),
}
BLOCKS = {**TABLES, **POLICY}
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


def rewritten(text: str) -> str:
    """Return a file with its generated blocks made again."""
    return markdown.rewritten(text, '|'.join(BLOCKS), lambda name: BLOCKS[name]())


if __name__ == '__main__':
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(config() if path.suffix == '.yaml' else rewritten(path.read_text()))
