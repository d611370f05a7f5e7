# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the web page costs: `python bench/bench_web.py`, two minutes, a table.

A simulated robot, its driver and `create_web`, without a page and with one that drives. Then how
soon the wheels are told to stand when the page says nothing more, and when it is closed. At last,
how soon they are told to turn when the stick is pressed in a Chromium without a window.
"""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
import json
import re
import shutil
import sys
from time import monotonic

import aiohttp
from playwright.sync_api import sync_playwright

from create_oi_ros.ros.programs import PROGRAMS
from results import Figure, repeated, run
from scene import drives, Process, Scene, scene

WATCH = 10.0
"""Seconds for which the processor time is measured."""
STOPS = 10
SETTLE = 3.0
"""Seconds until all have found each other."""
PRESSES = 20
PRESSED, RELEASED = 300, 1500
"""Milliseconds for which the stick is pressed, and until the robot stands again."""
TARGET, STOP_TARGET, PRESS_TARGET = 5.0, 0.3, 75.0
"""% of a core with one viewer; seconds until wheels are told to stand; ms until told to turn."""
TOLD, STANDS = 'wait right=0 left=0', 'wait speed<0.001'
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


async def share_with_a_page(web: Process, port: int) -> float:
    """Return the processor share, %, of a server whose only page drives."""
    async with page(port) as connection:
        measured = asyncio.create_task(asyncio.to_thread(web.processor_share, WATCH))
        await held(connection, measured.done)
        return await measured


async def stop_time(ask: Callable[[str], str], port: int, *, closing: bool) -> float:
    """Return the seconds from the last command until the wheels are told to stand."""
    async with page(port) as connection:
        def truth(line: str) -> dict[str, float]:
            return dict(json.loads(ask(line)))
        await asyncio.to_thread(truth, STANDS)  # it coasts after the time before
        await held(connection, lambda: truth('truth')['speed'] > SPEED / 2)
        begun = truth('truth')['time']
        if closing:
            await connection.close()
        told = await asyncio.to_thread(truth, TOLD)
        return told['time'] - begun


def started(stage: Scene) -> tuple[Process, int]:
    """Start driver and server; return the server and its port."""
    stage.start('-c', PROGRAMS['create_node'], '--ros-args', '-p', f'port:={stage.port}',
                '-p', 'cmd_vel_timeout:=10.0')
    web = stage.start('-c', PROGRAMS['create_web'], '--control', str(stage.control))
    deadline = monotonic() + 30
    while not (found := re.search(r'open http://\S+:(\d+)/', ''.join(web.errors))):
        assert monotonic() < deadline, web.errors
    return web, int(found[1])


def press_times(port: int) -> list[float]:
    """Return when the stick was pressed, seconds of the monotonic clock."""
    path = shutil.which('chromium') or sys.exit('no Chromium here: apt-get install chromium')
    pressed = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=['--no-sandbox'])
        shown = browser.new_page()
        shown.goto(f'http://127.0.0.1:{port}/')
        shown.wait_for_selector('#chip-link[data-level=good]')
        box = shown.locator('#stick').bounding_box()
        shown.mouse.move(box['x'] + box['width'] / 2, box['y'] + box['height'] / 4)
        for _ in range(PRESSES):
            shown.wait_for_timeout(RELEASED)
            pressed.append(monotonic())
            shown.mouse.down()
            shown.wait_for_timeout(PRESSED)
            shown.mouse.up()
        browser.close()
    return pressed


def measure() -> list[Figure]:
    with scene() as stage:
        robot = stage.robot()
        web, port = started(stage)
        asyncio.run(asyncio.sleep(SETTLE))
        alone = web.processor_share(WATCH)
        watched = asyncio.run(share_with_a_page(web, port))
        with stage.control_socket() as ask:
            silent, closed = (
                [asyncio.run(stop_time(ask, port, closing=closing)) for _ in range(STOPS)]
                for closing in (False, True))
        pressed = press_times(port)
        turns = [when for when, command in drives(robot.result()['received']) if command.right]
    presses = [1000 * (min(turn for turn in turns if turn > press) - press) for press in pressed]
    return [
        Figure('create_web, no page open: processor', alone, '% of a core'),
        Figure('create_web, one page that drives: processor', watched, '% of a core', TARGET),
        repeated('last word of a page to wheels told to stand', silent, 's', STOP_TARGET),
        repeated('page closed to wheels told to stand', closed, 's', STOP_TARGET),
        repeated('stick pressed in a browser to Drive Direct on the wire', presses, 'ms',
                 PRESS_TARGET)]


if __name__ == '__main__':
    run('bench_web', measure)
