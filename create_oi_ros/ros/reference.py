"""
The ROS interface as Markdown tables and as a parameter file, made from the declarations.

`python -m create_oi_ros.ros.reference README.md config/create.yaml` writes them: tables between
their markers, a parameter file as a whole.
"""

from collections.abc import Mapping
from dataclasses import fields
import json
from pathlib import Path
import sys
from textwrap import wrap
from typing import Any

from ..oi.tools import markdown
from .parameters import Parameters
from .services import SERVICES
from .topics import PUBLISHED

CONFIG_WIDTH = 93
"""Characters of a comment line."""


def type_name(type_: type) -> str:
    """Return the name of a message or service type as ROS writes it."""
    package = type_.__module__.partition('.')[0]
    return f'{package}/{type_.__name__}'


def topics() -> str:
    """Return the published topics."""
    return markdown.table(('topic', 'type', 'when', 'what'), (
        (f'`{topic.name}`', type_name(topic.type), topic.when, topic.about)
        for topic in PUBLISHED))


def services() -> str:
    """Return the services."""
    return markdown.table(('service', 'type', 'what'), (
        (f'`{service.name}`', type_name(service.type), service.about) for service in SERVICES))


def parameters() -> str:
    """Return the parameters."""
    rows = []
    for declared in fields(Parameters):
        facts = declared.metadata
        allowed = ', '.join(str(choice) for choice in facts['choices'])
        if facts['low'] is not None:
            allowed = f'{facts["low"]} to {facts["high"]}'
        value = declared.default
        default = str(value).lower() if isinstance(value, bool) else str(value) or "''"
        rows.append((
            f'`{declared.name}`', f'`{default}`', allowed,
            'at start' if facts['fixed'] else 'any time', facts['description']))
    return markdown.table(('parameter', 'default', 'allowed', 'set', 'what'), rows)


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
        about = declared.metadata['description'] + _allowed(declared.metadata)
        lines += [f'    # {line}' for line in wrap(about, CONFIG_WIDTH)]
        lines.append(f'    {declared.name}: {json.dumps(declared.default)}')
    return CONFIG_HEAD + '\n'.join(lines) + '\n'


def _allowed(facts: Mapping[str, Any]) -> str:
    if facts['choices']:
        return f' ({", ".join(str(choice) for choice in facts["choices"])})'
    return '' if facts['low'] is None else f' ({facts["low"]} to {facts["high"]})'


def rewritten(text: str) -> str:
    """Return a page with its tables made again."""
    return markdown.rewritten(text, '|'.join(TABLES), lambda name: TABLES[name]())


if __name__ == '__main__':
    for name in sys.argv[1:]:
        path = Path(name)
        path.write_text(config() if path.suffix == '.yaml' else rewritten(path.read_text()))
