# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes values into the text of a ROS parameter file, and leaves all else in it as it is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import yaml

SECTION = '/**'
"""Section that a file gets if it has none for the driver: the parameters of every node."""
DRIVER = 'create'
"""Name of the driver's node."""
Path = tuple[str, ...]
"""Keys that lead to a mapping."""
DEEPEST = 10
"""Mappings inside each other at most; an alias may lead to itself."""


def with_values(text: str, values: Mapping[str, float]) -> str:
    """Return a parameter file with these values changed or added; ValueError: why it cannot be."""
    try:
        content, tree = yaml.safe_load(text), yaml.compose(text, yaml.SafeLoader)
    except yaml.YAMLError as error:
        problem = ' '.join(str(error).split())
        raise ValueError(f'it is no ROS parameter file: {problem}') from error
    if tree is None:
        return text + _section(values)
    sections = dict(_sections(tree))
    if not sections:
        raise ValueError('it is no ROS parameter file: it has no ros__parameters')
    path = _wanted(sections, values)
    if path is None:
        made = f'{text.rstrip()}\n{_section(values)}'
        path = (SECTION, 'ros__parameters')
    else:
        made = _edited(text, sections[path], values)
    _check(made, content, path, values)
    return made


def _section(values: Mapping[str, float]) -> str:
    lines = (f'    {name}: {_number(value)}\n' for name, value in values.items())
    return f'{SECTION}:\n  ros__parameters:\n{"".join(lines)}'


def _number(value: float) -> str:
    return f'{value:.5f}'


def _sections(node: yaml.Node, path: Path = ()) -> Iterator[tuple[Path, yaml.MappingNode]]:
    """Yield the parameters of each node in the file."""
    if not isinstance(node, yaml.MappingNode) or len(path) == DEEPEST:
        return
    for key, value in node.value:
        if key.value == 'ros__parameters' and isinstance(value, yaml.MappingNode):
            yield (*path, key.value), value
        else:
            yield from _sections(value, (*path, key.value))


def _wanted(sections: Mapping[Path, yaml.MappingNode], names: Mapping[str, float]) -> Path | None:
    """Return the section of the driver; None: there is none; ValueError: there are several."""
    found = [path for path, parameters in sections.items()
             if path[-2:-1] and path[-2].rpartition('/')[2] in (DRIVER, '*', '**')
             or any(key.value in names for key, _ in parameters.value)]
    if len(found) > 1:
        nodes = ', '.join('/'.join(path[:-1]) for path in found)
        raise ValueError(f'it has parameters for several nodes that may be this robot ({nodes}): '
                         'give the robot a file of its own')
    return found[0] if found else None


def _edited(text: str, parameters: yaml.MappingNode, values: Mapping[str, float]) -> str:
    """Return the text with new values in place, and missing ones before the first parameter."""
    places = {key.value: value for key, value in parameters.value}
    edits = [(places[name].start_mark.index, places[name].end_mark.index, _number(value))
             for name, value in values.items() if name in places]
    missing = [f'{name}: {_number(value)}' for name, value in values.items()
               if name not in places]
    start, indent = parameters.start_mark.index, parameters.start_mark.column * ' '
    if parameters.flow_style:
        added = ''.join(f'{line}, ' for line in missing)
        edits.append((start + 1, start + 1, added if places else added.removesuffix(', ')))
    else:
        added = ''.join(f'{line}\n{indent}' for line in missing)
        edits.append((start, start, added))
    for first, last, new in sorted(edits, reverse=True):
        text = text[:first] + new + text[last:]
    return text


def _check(text: str, before: Any, path: Path, values: Mapping[str, float]) -> None:
    """Raise ValueError unless the new text says what the old one said, but for the values."""
    expected = before
    for key in path:
        expected = expected.setdefault(key, {})
    expected.update({name: float(_number(value)) for name, value in values.items()})
    try:
        right = yaml.safe_load(text) == before
    except yaml.YAMLError:
        right = False
    if not right:
        written = ', '.join(f'{name}: {_number(value)}' for name, value in values.items())
        raise ValueError(f'its form is too unusual to be changed here; write into it: {written}')
