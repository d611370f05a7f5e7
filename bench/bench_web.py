# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the web page costs: `python bench/bench_web.py`, half a minute, a table.

A simulated robot, its driver and `create_web`, without a page and with one that drives.
"""

import asyncio
import json
from time import sleep

import aiohttp

from create_oi_ros.ros.programs import PROGRAMS
from results import Figure, run
from scene import Process, Scene, shares

PORT = 8079
ADDRESS = f'http://127.0.0.1:{PORT}'
WATCH = 10.0
"""Seconds for which the processor time is measured."""
SETTLE = 10.0
"""Seconds until all run and have found each other."""
MOST = 5.0
"""% of a core with one page."""


async def share_with_a_page(web: Process) -> float:
    """Return the processor share, %, of a server whose only page holds the stick."""
    async with (aiohttp.ClientSession() as session,
                session.ws_connect(f'{ADDRESS}/live', origin=ADDRESS) as connection):
        measured = asyncio.create_task(asyncio.to_thread(shares, WATCH, web))
        while not measured.done():
            news = json.loads((await connection.receive()).data)
            if news['type'] == 'news':
                await connection.send_json({
                    'type': 'drive', 'linear': 0.2, 'angular': 0.5, 'seen': news['at']})
        return measured.result()[0]


def measure() -> list[Figure]:
    with Scene() as stage:
        stage.robot()
        stage.driver()
        web = stage.python('-c', PROGRAMS['create_web'], '--control', str(stage.control),
                           '--port', str(PORT))
        sleep(SETTLE)
        alone, = shares(WATCH, web)
        watched = asyncio.run(share_with_a_page(web))
    return [Figure('create_web, no page open: processor', alone, '% of a core'),
            Figure('create_web, one page that drives: processor', watched, '% of a core', MOST)]


if __name__ == '__main__':
    run('bench_web', measure)
