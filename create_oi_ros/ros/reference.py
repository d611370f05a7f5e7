"""
Writes the ROS interface as Markdown tables and as a parameter file, from the declarations.

`python -m create_oi_ros.ros.reference README.md config/create.yaml` replaces the tables between
their markers in the first, and all of the second.
"""

from collections.abc import Iterable, Mapping
from dataclasses import fields
import json
from pathlib import Path
import re
import sys
from textwrap import wrap
from typing import Any

from .parameters import Parameters
from .services import SERVICES
from .topics import PUBLISHED

CONFIG_WIDTH = 93
"""Characters of a comment line at most."""


def type_name(type_: type) -> str:
    """Return the name of a message or service type as ROS writes it."""
    package = type_.__module__.partition('.')[0]
    return f'{package}/{type_.__name__}'


def table(*columns: str, rows: Iterable[tuple[str, ...]]) -> str:
    """Return a Markdown table."""
    lines = [columns, tuple('---' for _ in columns), *rows]
    return '\n'.join(f'| {" | ".join(line)} |' for line in lines)


def topics() -> str:
    """Return the table of published topics."""
    return table('topic', 'type', 'when', 'what', rows=(
        (f'`{topic.name}`', type_name(topic.type), topic.when, topic.about)
        for topic in PUBLISHED))


def services() -> str:
    """Return the table of services."""
    return table('service', 'type', 'what', rows=(
        (f'`{service.name}`', type_name(service.type), service.about) for service in SERVICES))


def parameters() -> str:
    """Return the table of parameters."""
    rows = []
    for declared in fields(Parameters):
        facts, value = declared.metadata, declared.default
        default = str(value).lower() if isinstance(value, bool) else str(value) or "''"
        rows.append((
            f'`{declared.name}`', f'`{default}`', _allowed(facts),
            'at start' if facts['fixed'] else 'any time', facts['description']))
    return table('parameter', 'default', 'allowed', 'set', 'what', rows=rows)


TABLES = {'topics': topics, 'services': services, 'parameters': parameters}


CONFIG_HEAD = (
    '# Every parameter of create_node with its default; made by `make docs`. Copy it, change it:\n'
    '# ros2 run create_oi_ros create_node --ros-args --params-file my_create.yaml\n'
    '/**:\n'
    '  ros__parameters:\n')


def config() -> str:
    """Return a parameter file with all defaults."""
    lines = []
    for declared in fields(Parameters):
        about, allowed = declared.metadata['description'], _allowed(declared.metadata)
        about += f' ({allowed})' if allowed else ''
        lines += [f'    # {line}' for line in wrap(about, CONFIG_WIDTH)]
        lines.append(f'    {declared.name}: {json.dumps(declared.default)}')
    return CONFIG_HEAD + '\n'.join(lines) + '\n'


def _allowed(facts: Mapping[str, Any]) -> str:
    if facts['low'] is not None:
        return f'{facts["low"]} to {facts["high"]}'
    return ', '.join(str(choice) for choice in facts['choices'])


def rewritten(text: str) -> str:
    """Return a document with its tables replaced by new ones."""
    for name, make in TABLES.items():
        marked = re.compile(f'(<!-- {name} -->\n).*?(<!-- end -->)', re.DOTALL)
        text = marked.sub(rf'\1{make()}\n\2', text)
    return text


if __name__ == '__main__':
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(config() if path.suffix == '.yaml' else rewritten(path.read_text()))
