# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the web page costs: `python bench/bench_web.py`, a minute, a table.

A simulated robot, its driver and `create_web`, without a page and with one that drives. Then how
soon the wheels are told to stand when the page says nothing more, and when it is closed.
"""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
import json
from pathlib import Path
import re
from time import monotonic

import aiohttp

from create_oi_ros.ros.programs import PROGRAMS
from processes import processor_share
from results import Figure, repeated, run
from scene import Scene, scene

WATCH = 10.0
"""Seconds for which the processor time is measured."""
STOPS = 10
SETTLE = 3.0
"""Seconds until all have found each other."""
TARGET, STOP_TARGET = 5.0, 0.3
"""% of a core with one viewer; seconds until the wheels are told to stand."""
TOLD = 'wait right=0 left=0'
SPEED = 0.2


@asynccontextmanager
async def page(port: int) -> AsyncIterator[aiohttp.ClientWebSocketResponse]:
    """Yield a connection as the page has it."""
    address = f'http://127.0.0.1:{port}'
    async with (aiohttp.ClientSession() as session,
                session.ws_connect(f'{address}/live', origin=address) as connection):
        yield connection


async def held(connection: aiohttp.ClientWebSocketResponse, until: Callable[[], bool]) -> None:
    """Hold the stick while news arrive."""
    while not until():
        news = json.loads((await connection.receive()).data)
        if news['type'] == 'news':
            await connection.send_json({
                'type': 'drive', 'linear': SPEED, 'angular': 0.5, 'seen': news['at']})


async def share_with_a_page(web: int, port: int) -> float:
    """Return the processor share, %, of a server whose only page drives."""
    async with page(port) as connection:
        measured = asyncio.create_task(asyncio.to_thread(processor_share, web, WATCH))
        await held(connection, measured.done)
        return await measured


async def stop_time(ask: Callable[[str], str], port: int, *, closing: bool) -> float:
    """Return the seconds from the last command until the wheels are told to stand."""
    async with page(port) as connection:
        def truth(line: str) -> dict[str, float]:
            return dict(json.loads(ask(line)))
        await held(connection, lambda: truth('truth')['speed'] > SPEED / 2)
        begun = truth('truth')['time']
        if closing:
            await connection.close()
        told = await asyncio.to_thread(truth, TOLD)
        return told['time'] - begun


def started(stage: Scene, control: Path) -> tuple[int, int]:
    """Start robot, driver and server; return process id and port of the server."""
    stage.start('-c', PROGRAMS['create_sim'], '--link', str(stage.port),
                '--control', str(control)).line()
    stage.start('-c', PROGRAMS['create_node'], '--ros-args', '-p', f'port:={stage.port}',
                '-p', 'cmd_vel_timeout:=10.0')
    web = stage.start('-c', PROGRAMS['create_web'], '--control', str(control))
    deadline = monotonic() + 30
    while not (found := re.search(r'open http://\S+:(\d+)/', ''.join(web.errors))):
        assert monotonic() < deadline, web.errors
    return web.pid, int(found[1])


def measure() -> list[Figure]:
    """Measure all."""
    with scene() as stage:
        web, port = started(stage, stage.control)
        asyncio.run(asyncio.sleep(SETTLE))
        alone = processor_share(web, WATCH)
        watched = asyncio.run(share_with_a_page(web, port))
        with stage.control_socket() as ask:
            silent, closed = (
                [asyncio.run(stop_time(ask, port, closing=closing)) for _ in range(STOPS)]
                for closing in (False, True))
    return [
        Figure('create_web, no page open: processor', alone, '% of a core'),
        Figure('create_web, one page that drives: processor', watched, '% of a core', TARGET),
        repeated('last word of a page to wheels told to stand', silent, 's', STOP_TARGET),
        repeated('page closed to wheels told to stand', closed, 's', STOP_TARGET)]


if __name__ == '__main__':
    run('bench_web', measure)
