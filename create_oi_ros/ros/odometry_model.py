# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The file of what the odometry knows of a robot: parameter `odometry_model`.

The node reads it at start, and writes it on request and at the end. It is YAML that people can
read: hypotheses of the wheels with their probabilities, and numbers with their standard
deviations. docs/calibration.md describes it.
"""

from collections.abc import Mapping
from contextlib import suppress
from math import isfinite
import os
from pathlib import Path
import shutil
from typing import Any, TypeVar

from rclpy.node import Node
import yaml

from ..driver import Outcome
from ..driver.frame_clock import MAX_PERIOD, MIN_PERIOD
from ..link.session import Session
from ..odometry import Hypothesis, Knowledge, Known, KnownGyro, Response, Rounding, SignSource
from ..odometry.knowledge import TAUGHT

FORMAT, OLD_FORMATS = 2, (1,)
HEAD = """\
# What is known of a robot's wheels and counts, for the parameter odometry_model of create_node.
# Each number has its standard deviation; metres, seconds, m/s.
"""
DIGITS = 7
"""Significant digits in the file."""
NUMBERS = ('right_gain', 'left_gain', 'angle_factor', 'frame_period')
"""Numbers with a standard deviation."""
WHEELS = ('time', 'of_speed', 'overshoot', 'braking', 'dead_time', 'dead_band')
"""Numbers of a hypothesis."""
RANGES = {
    'right_gain': (0.3, 2.0), 'left_gain': (0.3, 2.0), 'angle_factor': (0.8, 1.2),
    'frame_period': (MIN_PERIOD, MAX_PERIOD), 'deviation': (0.0, 10.0),
    'zero': (0.0, 5.0), 'drift': (-0.1, 0.1), 'scale': (-1000.0, 1000.0),
    'time': (1e-3, 10.0), 'of_speed': (0.0, 1.0), 'overshoot': (0.0, 0.9),
    'braking': (0.05, 20.0), 'dead_time': (0.0, 0.4), 'dead_band': (0.0, 0.1),
    'probability': (0.0, 1.0)}
"""Of all numbers; of a gyro they are in V, V/s, degrees a second for each volt."""
MOST_HYPOTHESES = 64
NO_FILE = ('parameter odometry_model is empty: start the node with '
           '-p odometry_model:=FILE to have a file')
NOTHING = 'nothing was learned yet: drive and turn the robot first'
Thing = TypeVar('Thing')


class OldModel(Exception):
    """The file is of an older odometry, which this one cannot use."""


def read(path: Path) -> Knowledge | None:
    """
    Return what a file knows; None: there is no file yet; ValueError: why it is no good.

    OldModel: it was written by an older odometry.
    """
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
    content: dict[str, object] = {
        'format': FORMAT, **({} if verdict is None else {'verdict': dict(verdict)}),
        'rounding': {kind.value: _short(p) for kind, p in knowledge.rounding.items()},
        **{name: _pair(getattr(knowledge, name)) for name in NUMBERS},
        **({} if knowledge.gyro is None else {
            'gyro': {name: _pair(number) for name, number in knowledge.gyro._asdict().items()}}),
        'readings': knowledge.readings,
        'wheels': [{
            'probability': _short(p), 'response': row.response.name.lower(),
            'encoder_sign': row.sign.value,
            **{name: _short(getattr(row, name)) for name in WHEELS}}
            for row, p in knowledge.hypotheses.items()]}
    text: str = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=95)
    return text


def parsed(text: str) -> Knowledge:
    """Return what the content of a file says; ValueError: what is wrong with it, or OldModel."""
    try:
        content = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(f'it is no YAML: {" ".join(str(error).split())}') from error
    if not isinstance(content, dict) or 'format' not in content:
        raise ValueError("it is no model of a robot: it has no 'format'")
    if content['format'] in OLD_FORMATS:
        raise OldModel(f"format {content['format']} is of an older odometry")
    if content['format'] != FORMAT:
        raise ValueError(f"format {content['format']!r} is not known; it must be {FORMAT}")
    rows = content.get('wheels')
    if not isinstance(rows, list) or not 1 <= len(rows) <= MOST_HYPOTHESES:
        raise ValueError(f'wheels must be a list of 1 to {MOST_HYPOTHESES} hypotheses')
    for row in rows:
        _mapping(row, 'wheels: each hypothesis')
    rounding = _mapping(content.get('rounding'), 'rounding')
    for unknown in rounding.keys() - {kind.value for kind in Rounding}:
        raise ValueError(f'rounding: {unknown!r} is unknown; allowed: '
                         f'{", ".join(kind.value for kind in Rounding)}')
    gyro = None
    if 'gyro' in content:
        numbers = _mapping(content['gyro'], 'gyro')
        gyro = KnownGyro(*(_known(numbers, name) for name in KnownGyro._fields))
    hypotheses = {
        Hypothesis(
            response=_choice(row, 'response', {each.name.lower(): each for each in Response}),
            sign=_choice(row, 'encoder_sign', {each.value: each for each in SignSource}),
            **{name: _number(row, name) for name in WHEELS}): _number(row, 'probability')
        for row in rows}
    known: dict[str, Any] = {name: _known(content, name) for name in NUMBERS}
    return Knowledge(
        gyro=gyro, **known, hypotheses=_normalised(hypotheses, 'wheels'),
        rounding=_normalised(
            {kind: _number({kind.value: 0.0, **rounding}, kind.value, 'probability')
             for kind in Rounding}, 'rounding'))


def _mapping(value: Any, name: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError(f'{name} is missing' if value is None else f'{name} must be a mapping')
    return value


def _choice(row: dict[str, Any], name: str, allowed: Mapping[str, Thing]) -> Thing:
    if row.get(name) not in list(allowed):
        raise ValueError(f'{name} is {row.get(name)!r}; allowed: {", ".join(allowed)}')
    return allowed[row[name]]


def _pair(number: Known) -> dict[str, float]:
    return {'value': _short(number.value), 'deviation': _short(number.deviation)}


def _short(value: float) -> float:
    return float(f'{value:.{DIGITS}g}')


def _known(content: Mapping[str, Any], name: str) -> Known:
    pair = _mapping(content.get(name), name)
    try:
        return Known(_number(pair, 'value', name), _number(pair, 'deviation'))
    except ValueError as error:
        raise ValueError(f'{name}: {error}') from error


def _number(content: Mapping[str, Any], name: str, range_of: str = '') -> float:
    """Return a number within its range; ValueError: it is not one."""
    value, (low, high) = content.get(name), RANGES[range_of or name]
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise ValueError(f'{name} is {value!r}: a number is wanted')
    if not low <= value <= high:
        raise ValueError(f'{name} is {value}; allowed: {low:g} to {high:g}')
    return float(value)


def _normalised(weights: Mapping[Thing, float], name: str) -> dict[Thing, float]:
    if sum(weights.values()) <= 0:
        raise ValueError(f'{name}: no probability is above 0')
    return {kind: weight / sum(weights.values()) for kind, weight in weights.items()}


class ModelKeeper:
    """Keeps the file; a path that is empty keeps none."""

    def __init__(self, node: Node, path: str) -> None:
        """Read the file; ValueError says what is wrong with it."""
        self._log = node.get_logger()
        self._path = Path(path).expanduser() if path else None
        self.robot: Knowledge | None = None
        """What the file says; None where there is none."""
        if self._path is None:
            return
        try:
            self.robot = read(self._path)
        except OldModel as error:
            aside = self._path.with_name(f'{self._path.name}.old')
            try:
                self._path.replace(aside)
            except OSError as why:
                raise ValueError(f'parameter odometry_model: {self._path}: {error}, and it cannot '
                                 f'be moved to {aside}: {why.strerror}') from why
            self._log.warning(f'{self._path}: {error}: it is kept as {aside}, and the robot is '
                              'learned anew')
        except ValueError as error:
            raise ValueError(f'parameter odometry_model: {error}') from error
        self._log.info(
            f'{self._path} does not exist: the odometry learns the robot, and the file is '
            'written at the end' if self.robot is None else
            f'the odometry starts with what {self._path} knows of this robot')

    def save(self, session: Session) -> Outcome:
        """Write what is known now."""
        if self._path is None:
            return Outcome(False, NO_FILE)
        robot = _known_by(session)
        if robot is None:
            return Outcome(False, NOTHING)
        try:
            write(self._path, robot)
        except OSError as error:
            return Outcome(False, f'{self._path} cannot be written: {error.strerror}')
        unsure = '' if robot.certain else '; the robot is not known well yet: drive and turn more'
        return Outcome(True, f'written to {self._path}{unsure}')

    def end(self, session: Session) -> None:
        """Write what was learned, where it is more than the file says."""
        robot = _known_by(session)
        if self._path is None or robot is None:
            return
        if not robot.certain or robot.readings < TAUGHT:
            self._log.info(f'too little was learned of the robot: {self._path} stays as it is')
            return
        outcome = self.save(session)
        if outcome.ok:
            self._log.info(f'what was learned of the robot is {outcome.text}')
        else:
            self._log.error(outcome.text)


def _known_by(session: Session) -> Knowledge | None:
    with session.request() as (driver, now):
        return driver.health(now).robot


def write_whole(target: Path, content: bytes) -> None:
    """
    Write a file beside the target and rename it, so that a full disk leaves the target as it was.

    A device such as /dev/stdout is written directly. OSError: it cannot be; it names the target.
    """
    real = Path(os.path.realpath(target))
    beside = real.with_name(f'.{real.name}.{os.getpid()}')
    try:
        if real.exists() and not real.is_file():
            real.write_bytes(content)
            return
        beside.write_bytes(content)
        if real.exists():
            shutil.copymode(real, beside)
        beside.replace(real)
    except OSError as error:
        with suppress(OSError):  # where it could not be created
            beside.unlink()
        raise OSError(error.errno, error.strerror, str(target)) from error
