# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Asks the control socket of a simulated robot for its room, and where the robot really is."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import closing
import json
from math import cos, sin
from pathlib import Path
from typing import Any

from ...ros.collector import FlatPose
from .live_robot import LiveRobot

PERIOD = 0.1
"""Seconds between two questions."""
RETRY = 1.0
"""Seconds until the next attempt when nobody answers."""
TRIES = 5
"""Attempts in vain after which this is said."""
LONGEST_ANSWER = 1 << 20
"""Bytes."""


def room_origin(odometry: FlatPose, true: FlatPose) -> FlatPose:
    """Return the room's frame as a pose in the odometry's frame, where both poses are one."""
    yaw = odometry.yaw - true.yaw
    return FlatPose(odometry.x - true.x * cos(yaw) + true.y * sin(yaw),
                    odometry.y - true.x * sin(yaw) - true.y * cos(yaw), yaw)


async def show_truth(path: Path, robot: LiveRobot, say: Callable[[str], object]) -> None:
    """
    Put the room and the true pose into what the pages show, until cancelled.

    The room's frame is set when both poses are first known, and again after the odometry has begun
    anew. From then on the true place drifts away from that of the odometry: its error. `say` gets
    a sentence, once, if no simulator answers.
    """
    failures = 0
    while True:  # a simulator may start later, or again
        try:
            reader, writer = await asyncio.open_unix_connection(path, limit=LONGEST_ANSWER)
            with closing(writer):
                await _ask_on(reader, writer, robot)
        except (OSError, ValueError, KeyError) as error:  # it has gone, or is something else
            robot.parts.put('true_pose', None)
            failures += 1
            if failures == TRIES:
                say(f'--control {path}: no simulated robot answers there '
                    f'({getattr(error, "strerror", None) or "it is something else"}), so the map '
                    'has no room; start create_sim with the same --control')
        await asyncio.sleep(RETRY)


async def _ask_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter,
                  robot: LiveRobot) -> None:
    """Ask again and again; ConnectionError: nobody answers, ValueError: no JSON."""
    async def ask(word: str) -> Any:
        writer.write(f'{word}\n'.encode())
        answer = await reader.readline()
        if not answer.endswith(b'\n'):
            raise ConnectionError('the simulator has closed the connection')
        return json.loads(answer.removeprefix(b'ok '))
    robot.parts.put('room', await ask('room'))
    resets = -1
    while True:
        await asyncio.sleep(PERIOD)
        if robot.collector.pose is None:
            continue
        truth = await ask('truth')
        true = FlatPose(truth['x'], truth['y'], truth['yaw'])
        if resets != robot.resets:
            resets = robot.resets
            robot.parts.put('room_origin', room_origin(robot.collector.pose, true))
        robot.parts.put('true_pose', [round(each, 4) for each in true])
