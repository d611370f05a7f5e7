# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The file of what the odometry knows of a robot: parameter `odometry_model`.

The node reads it at start, and writes it on request and at the end. It is YAML that people can
read and write: probabilities, and numbers with their standard deviations. One table says what it
has; docs/calibration.md describes it.
"""

from collections.abc import Iterable, Mapping
from contextlib import suppress
import os
from pathlib import Path
import shutil
from typing import Any

from rclpy.node import Node
import yaml

from ..driver import Outcome
from ..driver.frame_clock import MAX_PERIOD, MIN_PERIOD
from ..link.session import Session
from ..odometry import Knowledge, Known, KnownGyro, Rounding, SignSource
from ..odometry.estimate import TAUGHT

FORMAT, OLD_FORMATS = 3, (1, 2)
HEAD = """\
# What is known of a robot's wheels and counts, for the parameter odometry_model of create_node.
# Each number has its standard deviation; metres, seconds, m/s.
"""
CHANCES: dict[str, type[Rounding] | type[SignSource]] = {
    'rounding': Rounding, 'encoder_sign': SignSource}
NUMBERS = {
    'right_gain': (0.1, 3.0), 'left_gain': (0.1, 3.0), 'angle_factor': (0.7, 1.3),
    'lag': (1e-3, 2.0), 'lag_power': (0.0, 1.0), 'acceleration': (0.05, 100.0),
    'braking': (0.1, 10.0), 'dead_time': (0.0, 0.4), 'frame_period': (MIN_PERIOD, MAX_PERIOD)}
GYRO = {'zero': (0.0, 5.0), 'scale': (-1000.0, 1000.0)}
"""All that a file has, beside `readings`: names of `Knowledge`, and ranges. A gyro's are V, and
degrees a second for each volt."""
LEAST_SCALE, MOST_DEVIATION, MOST_READINGS, SUM_SLACK = 1.0, 100.0, 10 ** 9, 1e-3


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
    content = {
        'format': FORMAT, **({} if verdict is None else {'verdict': dict(verdict)}),
        **{name: {each.value: chance for each, chance in getattr(knowledge, name).items()}
           for name in CHANCES},
        **{name: getattr(knowledge, name)._asdict() for name in NUMBERS},
        **({} if knowledge.gyro is None else {
            'gyro': {name: getattr(knowledge.gyro, name)._asdict() for name in GYRO}}),
        'readings': knowledge.readings}
    text: str = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=95)
    return text


def parsed(text: str) -> Knowledge:
    """Return what the content of a file says; ValueError: what is wrong with it, or OldModel."""
    try:
        content = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, AttributeError, LookupError, RecursionError) as error:
        # The last four: of values with a tag, such as `!!bool perhaps`, and of lists in lists.
        raise ValueError(f'it is no YAML: {" ".join(str(error).split())}') from error
    if not isinstance(content, dict) or 'format' not in content:
        raise ValueError("it is no model of a robot: it has no 'format'")
    if content['format'] in OLD_FORMATS:
        raise OldModel(f"format {content['format']} is of an older odometry")
    if content['format'] != FORMAT:
        raise ValueError(f"format {content['format']!r} is not known; it must be {FORMAT}")
    _check_names(content, ('format', 'verdict', *CHANCES, *NUMBERS, 'gyro', 'readings'))
    gyro = None
    if 'gyro' in content:
        gyro = KnownGyro(**_numbers(_mapping(content, 'gyro', GYRO), GYRO, 'gyro: '))
        if abs(gyro.scale.value) < LEAST_SCALE:
            raise ValueError(f'gyro: scale: value is {gyro.scale.value}; allowed: {LEAST_SCALE:g} '
                             'or more, or as much below zero')
    chances: dict[str, Any] = {name: _chances(content, name) for name in CHANCES}
    return Knowledge(
        **chances, **_numbers(content, NUMBERS), gyro=gyro,
        readings=int(_number(content, 'readings', (0, MOST_READINGS))))


def _chances(content: Mapping[str, Any], name: str) -> dict[Any, float]:
    """Return the probability of each choice."""
    choices = {each.value: each for each in CHANCES[name]}
    given = _mapping(content, name, choices)
    found = {each: _number({value: 0.0, **given}, value, (0.0, 1.0), f'{name}: ')
             for value, each in choices.items()}
    if abs(sum(found.values()) - 1) > SUM_SLACK:
        raise ValueError(f'{name}: the probabilities add up to {sum(found.values()):g}, not to 1')
    return found


def _numbers(content: Mapping[str, Any], ranges: Mapping[str, tuple[float, float]],
             where: str = '') -> dict[str, Any]:
    """Return numbers with their deviations."""
    found = {}
    for name, allowed in ranges.items():
        pair = _mapping(content, name, Known._fields, where)
        found[name] = Known(*(_number(pair, each, limits, f'{where}{name}: ') for each, limits in (
            ('value', allowed), ('deviation', (0.0, MOST_DEVIATION)))))
    return found


def _mapping(content: Mapping[str, Any], name: str, allowed: Iterable[str], where: str = '',
             ) -> dict[str, Any]:
    value = content.get(name)
    if not isinstance(value, dict):
        raise ValueError(f'{where}{name} is missing' if value is None else
                         f'{where}{name} must be a mapping')
    _check_names(value, allowed, f'{where}{name}: ')
    return value


def _check_names(value: Mapping[str, Any], allowed: Iterable[str], where: str = '') -> None:
    for unknown in value.keys() - set(allowed):
        raise ValueError(f'{where}{unknown!r} is unknown; allowed: {", ".join(allowed)}')


def _number(content: Mapping[str, Any], name: str, limits: tuple[float, float],
            where: str = '') -> float:
    """Return a number within its limits; ValueError: it is not one."""
    value, (low, high) = content.get(name), limits
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f'{where}{name} is {value!r}: a number is wanted')
    if not low <= value <= high:
        raise ValueError(f'{where}{name} is {value}; allowed: {low:g} to {high:g}')
    return float(value)


class ModelKeeper:
    """Keeps the file; a path that is empty keeps none."""

    def __init__(self, node: Node, path: str) -> None:
        """Read the file; ValueError says what is wrong with it."""
        self._log = node.get_logger()
        self._path = Path(os.path.expanduser(path)) if path else None
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
            return Outcome(False, 'parameter odometry_model is empty: start the node with '
                           '-p odometry_model:=FILE to have a file')
        robot = session.health().robot
        if robot is None:
            return Outcome(False, 'nothing was learned yet: drive and turn the robot first')
        try:
            write(self._path, robot)
        except OSError as error:
            return Outcome(False, f'{self._path} cannot be written: {error.strerror}')
        unsure = '' if robot.certain else '; the robot is not known well yet: drive and turn more'
        return Outcome(True, f'written to {self._path}{unsure}')

    def end(self, session: Session) -> None:
        """Write what was learned, where it is more than the file says."""
        robot = session.health().robot
        if self._path is None or robot is None:
            return
        if not robot.certain or robot.readings < TAUGHT:
            self._log.info(f'too little was learned of the robot: {self._path} is not written')
            return
        outcome = self.save(session)
        if outcome.ok:
            self._log.info(f'what was learned of the robot is {outcome.text}')
        else:
            self._log.error(outcome.text)


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
