# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The node's file of what its odometry knows: read at start, written on request and at the end."""

from pathlib import Path

from rclpy.node import Node

from ..driver import Outcome
from ..link.session import Session
from ..odometry import Knowledge
from . import odometry_model

MIN_READINGS = 30
"""Readings since the start from which on the file is written at the end."""
NO_FILE = ('parameter odometry_model is empty: start the node with '
           '-p odometry_model:=FILE to have a file')
NOTHING = 'nothing was learned yet: drive and turn the robot first'


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
            self.robot = odometry_model.read(self._path)
        except odometry_model.OldModel as error:
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
            odometry_model.write(self._path, robot)
        except OSError as error:
            return Outcome(False, f'{self._path} cannot be written: {error.strerror}')
        unsure = '' if robot.certain else '; the robot is not known well yet: drive and turn more'
        return Outcome(True, f'written to {self._path}{unsure}')

    def end(self, session: Session) -> None:
        """Write what was learned, where it is more than the file says."""
        robot = _known_by(session)
        if self._path is None or robot is None:
            return
        if not robot.certain or robot.readings < MIN_READINGS:
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
