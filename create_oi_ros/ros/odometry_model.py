# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The file of what the odometry knows of a robot: parameter `odometry_model`.

YAML that people can read: probabilities, numbers with their standard deviations, and how these are
correlated. docs/robot_check.md describes it.
"""

from collections.abc import Mapping
from enum import Enum
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

import yaml

from ..driver.frame_clock import LONGEST, SHORTEST
from ..odometry import Family, Knowledge, Known, Rounding, SignSource
from ..odometry.dead_band import FASTEST, SLOWEST
from ..odometry.knowledge import NUMBERS, STATES
from .whole_file import write_whole

FORMAT = 1
HEAD = """\
# What is known of a robot's wheels and counts, for the parameter odometry_model of create_node.
# Each number has its standard deviation; metres, seconds, m/s.
"""
DIGITS = 7
"""Significant digits in the file."""
Kind = TypeVar('Kind', bound=Enum)


def read(path: Path) -> Knowledge | None:
    """Return what a file knows; None: there is no file yet; ValueError: why it is no good."""
    try:
        text = path.read_text('utf-8')
    except FileNotFoundError:
        if not path.parent.is_dir():
            raise ValueError(f'{path.parent} is no folder, so no file can be written there') \
                from None
        return None
    except OSError as error:
        raise ValueError(f'{path} cannot be read: {error.strerror}') from error
    except UnicodeDecodeError:
        raise ValueError(f'{path} is no text') from None
    try:
        return parsed(text)
    except ValueError as error:
        raise ValueError(f'{path}: {error}; delete the file to learn the robot anew') from error


def write(path: Path, knowledge: Knowledge, verdict: Mapping[str, object] | None = None) -> None:
    """Write a file as a whole or not at all, maybe with a verdict for people; OSError: why not."""
    write_whole(path, (HEAD + text_of(knowledge, verdict)).encode())


def text_of(knowledge: Knowledge, verdict: Mapping[str, object] | None = None) -> str:
    """Return the content of a file."""
    content: dict[str, object] = {
        'format': FORMAT, **({} if verdict is None else {'verdict': dict(verdict)}),
        'rounding': _weights(knowledge.rounding), 'encoder_sign': _weights(knowledge.encoder_sign),
        'response': _weights(knowledge.response),
        **{name: _number(getattr(knowledge, name))
           for name in (*knowledge.numbers, 'frame_period')},
        'dead_band': {'stands': _short(knowledge.dead_band[0]),
                      'moves': _short(knowledge.dead_band[1])},
        'readings': knowledge.readings,
        'correlations': [[_short(each) for each in row] for row in knowledge.correlations]}
    text: str = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=95)
    return text


def parsed(text: str) -> Knowledge:
    """Return what the content of a file says; ValueError: what is wrong with it."""
    try:
        content = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(f'it is no YAML: {" ".join(str(error).split())}') from error
    if not isinstance(content, dict) or 'format' not in content:
        raise ValueError("it is no model of a robot: it has no 'format'")
    if content['format'] != FORMAT:
        raise ValueError(f"format {content['format']!r} is not known; it must be {FORMAT}")
    period = _known(content, 'frame_period', SHORTEST, LONGEST)
    response = (_probabilities(content, 'response', Family) if 'response' in content
                else {Family.LAG: 1.0})  # older files know of no other
    numbers: dict[str, Any] = {
        name: _known(content, name, *number.range)
        for name, number in NUMBERS[max(response, key=response.__getitem__)].items()}
    return Knowledge(
        rounding=_probabilities(content, 'rounding', Rounding),
        encoder_sign=_probabilities(content, 'encoder_sign', SignSource), response=response,
        **numbers,
        dead_band=_band(_field(content, 'dead_band', dict)),
        correlations=_correlations(_field(content, 'correlations', list)), frame_period=period)


def _short(value: float) -> float:
    return float(f'{value:.{DIGITS}g}')


def _number(known: Known) -> dict[str, float]:
    return {'value': _short(known.value), 'deviation': _short(known.deviation)}


def _weights(weights: Mapping[Kind, float]) -> dict[str, float]:
    return {kind.value: _short(weight) for kind, weight in weights.items()}


def _field(content: Mapping[str, Any], name: str, type_: type[dict[Any, Any] | list[Any]]) -> Any:
    if not isinstance(content.get(name), type_):
        what = 'a mapping' if type_ is dict else 'a list'
        raise ValueError(f'{name} is missing' if name not in content
                         else f'{name} must be {what}')
    return content[name]


def _real(value: Any, name: str, low: float, high: float) -> float:
    """Return a number within a range; ValueError: it is not one."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise ValueError(f'{name} is {value!r}: a number is wanted')
    if not low <= value <= high:
        raise ValueError(f'{name} is {value}; allowed: {low:g} to {high:g}')
    return float(value)


def _known(content: Mapping[str, Any], name: str, low: float, high: float) -> Known:
    number = _field(content, name, dict)
    value = _real(number.get('value'), f'{name}: value', _short(low), _short(high))
    return Known(min(high, max(low, value)),
                 _real(number.get('deviation'), f'{name}: deviation', 1e-9, 10.0))


def _probabilities(content: Mapping[str, Any], name: str, kinds: type[Kind]) -> dict[Kind, float]:
    given = _field(content, name, dict)
    allowed = [kind.value for kind in kinds]
    for unknown in given.keys() - set(allowed):
        raise ValueError(f'{name}: {unknown!r} is unknown; allowed: {", ".join(allowed)}')
    weights = {kind: _real(given.get(kind.value, 0.0), f'{name}: {kind.value}', 0.0, 1.0)
               for kind in kinds}
    if sum(weights.values()) <= 0:
        raise ValueError(f'{name}: no probability is above 0')
    return {kind: weight / sum(weights.values()) for kind, weight in weights.items()}


def _band(band: Mapping[str, Any]) -> tuple[float, float]:
    stands = _real(band.get('stands'), 'dead_band: stands', SLOWEST, FASTEST)
    moves = _real(band.get('moves'), 'dead_band: moves', SLOWEST, FASTEST)
    if stands >= moves:
        raise ValueError(f'dead_band: stands {stands} must be below moves {moves}')
    return stands, moves


def _correlations(rows: list[Any]) -> tuple[tuple[float, ...], ...]:
    wanted = len(STATES) - 1
    if [len(row) if isinstance(row, list) else None for row in rows] != [*range(1, wanted + 1)]:
        raise ValueError(f'correlations must be {wanted} rows of 1 to {wanted} numbers')
    return tuple(tuple(_real(each, 'correlations', -1.0, 1.0) for each in row) for row in rows)
