# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Asks the control socket of a simulated robot for its room, and where the robot really is."""

from __future__ import annotations

import asyncio
import json
from math import cos, sin
from pathlib import Path
from typing import Any

from .live_robot import LiveRobot
from .past import FlatPose

PERIOD = 0.1
"""Seconds between two questions."""
RETRY = 1.0
"""Seconds until the next attempt when nobody answers."""
LONGEST_ANSWER = 1 << 20
"""Bytes."""


def room_origin(odometry: FlatPose, true: FlatPose) -> FlatPose:
    """Return the room's frame as a pose in the odometry's frame, where both poses are one."""
    yaw = odometry.yaw - true.yaw
    return FlatPose(odometry.x - true.x * cos(yaw) + true.y * sin(yaw),
                    odometry.y - true.x * sin(yaw) - true.y * cos(yaw), yaw)


class SimulatedTruth:
    """
    Puts the room and the true pose into what the pages show.

    The room's frame is set when both poses are first known, and again after the odometry has begun
    anew. From then on the true place drifts away from that of the odometry: its error.
    """

    def __init__(self, path: Path, robot: LiveRobot) -> None:
        """Ask at this socket, once `run` is called."""
        self._path, self._robot = path, robot
        self._resets = -1
        """Number of the reset of the odometry for which the frame was set."""
        self.asking = True
        """Whether anybody looks; else no questions are asked."""

    async def run(self) -> None:
        """Ask until cancelled; a simulator may start later, or again."""
        while True:
            try:
                await self._ask_on()
            except (OSError, ValueError, KeyError):  # it has gone, or is something else
                self._robot.parts.put('true_pose', None)
            await asyncio.sleep(RETRY)

    async def _ask_on(self) -> None:
        reader, writer = await asyncio.open_unix_connection(self._path, limit=LONGEST_ANSWER)
        try:
            self._robot.parts.put('room', await self._ask(reader, writer, 'room'))
            while True:
                if self.asking:
                    self._show(await self._ask(reader, writer, 'truth'))
                await asyncio.sleep(PERIOD)
        finally:
            writer.close()

    async def _ask(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter,
                   word: str) -> Any:
        """Return the answer to a word; ConnectionError: there is none, ValueError: no JSON."""
        writer.write(f'{word}\n'.encode())
        answer = await reader.readline()
        if not answer.endswith(b'\n'):
            raise ConnectionError('the simulator has closed the connection')
        return json.loads(answer.removeprefix(b'ok '))

    def _show(self, truth: dict[str, Any]) -> None:
        robot = self._robot
        if robot.pose is None:
            return
        true = FlatPose(truth['x'], truth['y'], truth['yaw'])
        if self._resets != robot.resets:
            self._resets = robot.resets
            robot.parts.put('room_origin', room_origin(robot.pose, true))
        robot.parts.put('true_pose', [round(each, 4) for each in true])
