# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What pages are in tests: a WebSocket client, a relay that can fail, a page of a browser."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import closing, suppress
import http.client
import json
import re
import socket
import threading
import time
from typing import Any

import aiohttp
import pytest

from support.ros import Listener, Program, Robot, Scene, TIMEOUT

ADDRESS = re.compile(r'open (https?://\S+:(\d+)/\S*) in a browser')
LONG = 10.0
"""`cmd_vel_timeout`, s: only page and server stop the wheels in time, not the driver."""
IN_TIME = 0.8 * LONG
"""Seconds to wait for wheels that stop before the driver ends the last command."""


def served(stage: Scene, *arguments: str) -> tuple[Program, str]:
    """Start `create_web` on a free port; return it and the address that it prints."""
    port = [] if '--port' in arguments else ['--port', str(free_port())]
    web = stage.program('create_web', *port, *arguments)
    stage.ros.until(lambda: ADDRESS.search(web.output) or not web.running(), 'an address')
    found = ADDRESS.search(web.output)
    assert found, web.output
    return web, found[1]


def free_port() -> int:
    """Return a TCP port that nobody listens on."""
    with socket.create_server(('127.0.0.1', 0)) as probe:
        return int(probe.getsockname()[1])


def port_of(address: str) -> int:
    """Return the port in an address."""
    return int(address.partition('?')[0].rstrip('/').rpartition(':')[2])


def get(address: str, path: str, **headers: str) -> tuple[int, dict[str, str], str]:
    """Ask for a path as it stands, with just these headers; return status, headers, body."""
    host = address.removeprefix('http://').partition('/')[0]
    with closing(http.client.HTTPConnection(host, timeout=20)) as connection:
        connection.putrequest('GET', path, skip_host='Host' in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, dict(answer.getheaders()), answer.read().decode()


class PageClient:
    """Speaks with the server as the page does; what it is told is merged into `known`."""

    def __init__(self, address: str, *, origin: str | None = None, token: str = '',
                 name: str = '') -> None:
        """Connect, and wait for the first news; aiohttp.WSServerHandshakeError: refused."""
        self._loop = asyncio.new_event_loop()
        self.address = address
        self.known: dict[str, Any] = {
            'at': 0.0, 'events': [], 'track': [], 'samples': []}
        self.replies: list[dict[str, Any]] = []
        self.close_code: int | None = None
        self._session = self._run(self._open_session())
        base = address.partition('?')[0].rstrip('/')
        cookies = {'Cookie': f'create_web_{port_of(address)}={token}'} if token else {}
        try:
            self._socket = self._run(self._session.ws_connect(
                f'{base}/live', params={'page': name} if name else {},
                origin=base if origin is None else origin, headers=cookies))
        except aiohttp.WSServerHandshakeError:
            self._run(self._session.close())
            self._loop.close()
            raise
        while 'seat' not in self.known and self.close_code is None:
            self.read()

    async def _open_session(self) -> aiohttp.ClientSession:
        return aiohttp.ClientSession()

    def _run(self, coroutine: Any) -> Any:
        return self._loop.run_until_complete(coroutine)

    def send(self, type_: str, **fields: object) -> None:
        """Send a message."""
        self.send_text(json.dumps({'type': type_, **fields}))

    def send_text(self, text: str) -> None:
        """Send any text."""
        self._run(self._socket.send_str(text))

    def send_bytes(self, data: bytes) -> None:
        """Send a binary message."""
        self._run(self._socket.send_bytes(data))

    def read(self) -> None:
        """Take the next message of the server; sets `close_code` when there is none any more."""
        message = self._run(self._socket.receive(TIMEOUT))
        if message.type is not aiohttp.WSMsgType.TEXT:
            self.close_code = self._socket.close_code
            return
        found = json.loads(message.data)
        if found['type'] == 'reply':
            self.replies.append(found)
            return
        if 'anew' in found:
            self.known['events'], self.known['track'] = [], found['anew']
        for name in ('events', 'track', 'samples'):
            self.known[name] += found.pop(name, [])
        self.known.update(found)

    def until(self, happened: Callable[[], Any]) -> Any:
        """Read until a condition is true; return its value."""
        while not (value := happened()):
            assert self.close_code is None, f'closed with {self.close_code}'
            self.read()
        return value

    def reply(self) -> dict[str, Any]:
        """Wait for the next reply, and take it."""
        self.until(lambda: self.replies)
        return self.replies.pop(0)

    def closed(self) -> int:
        """Read until the server closes; return its code."""
        while self.close_code is None:
            self.read()
        return self.close_code

    def drive(self, linear: float, angular: float, until: Callable[[], Any]) -> None:
        """Hold the stick until a condition is true; do not let it go."""
        def held() -> Any:
            self.send('drive', linear=linear, angular=angular, seen=self.known['at'])
            self.read()
            return until()
        self.until(held)

    def close(self) -> None:
        """Close the page."""
        if self._loop.is_closed():
            return
        self._run(self._socket.close())
        self._run(self._session.close())
        self._loop.close()


def refusal(open_page, address, **arguments) -> int:
    """Return the status with which a connection is refused."""
    with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
        open_page(address, **arguments)
    return int(refused.value.status)


def ready(page: PageClient) -> PageClient:
    """Wait until a page shows a robot in SAFE that can be driven; return the page."""
    page.until(lambda: page.known.get('driver_found')
               and page.known.get('mode', {}).get('actual') == 'SAFE')
    return page


def stops_in_time(ros: Listener, robot: Robot) -> None:
    """Wait until a robot was told to stand by page or server, not by the driver's timeout."""
    ros.until(lambda: robot.standing, 'a stop by page or server', IN_TIME)


class Relay:
    """A bad network: passes TCP bytes on, late; or none any more, and nobody is told."""

    def __init__(self, address: str) -> None:
        """Listen at `self.address`, and connect whoever comes with the server of an address."""
        self._listener = socket.create_server(('127.0.0.1', 0))
        self.address = f'http://127.0.0.1:{self._listener.getsockname()[1]}/'
        self._target = port_of(address)
        self.delay = 0.0
        """Seconds for which bytes are on their way at least, in each direction."""
        self._moving = threading.Event()
        self._moving.set()
        self._sockets = [self._listener]
        self._begin(self._accept)

    def _begin(self, work: Callable[..., None], *arguments: object) -> None:
        threading.Thread(target=work, args=arguments, daemon=True).start()

    def _accept(self) -> None:
        while True:
            try:
                near, _ = self._listener.accept()
            except OSError:
                return
            far = socket.create_connection(('127.0.0.1', self._target))
            self._sockets += [near, far]
            for source, target in ((near, far), (far, near)):
                self._begin(self._pass_on, source, target, self._moving)

    def _pass_on(self, source: socket.socket, target: socket.socket,
                 moving: threading.Event) -> None:
        with suppress(OSError):  # one end has gone
            while data := source.recv(65536):
                time.sleep(self.delay)
                moving.wait()
                target.sendall(data)
        moving.wait()
        with suppress(OSError):
            target.shutdown(socket.SHUT_WR)

    def freeze(self) -> None:
        """Pass nothing on any more."""
        self._moving.clear()

    def abandon(self) -> None:
        """Let new connections through; those of before stay frozen."""
        self._moving = threading.Event()
        self._moving.set()

    def thaw(self) -> None:
        """Pass on what has arrived meanwhile, all at once, and all that follows."""
        self._moving.set()

    def close(self) -> None:
        """Close everything."""
        self._moving.set()
        for each in self._sockets:
            each.close()


# A real Chromium without a window, driven by Playwright.


TIMEOUT_MS, POLL_MS = 20_000, 50


class OpenPage:
    """
    A page, and what its console complains about.

    It shows one address after the other: a new page takes the browser half a second of work.
    """

    def __init__(self, browser: Any) -> None:
        """Show nothing yet."""
        self._context = browser.new_context(has_touch=True)
        self._context.set_default_timeout(TIMEOUT_MS)
        self.page = self._context.new_page()
        self.errors: list[str] = []
        self.page.on('pageerror', lambda error: self.errors.append(str(error)))
        self.page.on('console', lambda message: message.type == 'error' and self.errors.append(
            message.text))

    def open(self, address: str, width: int, height: int) -> None:
        """Open an address in a window of this size."""
        self.resize(width, height)
        self.page.goto(address)

    def live(self) -> None:
        """Wait until the page shows a robot that can be driven."""
        self.page.wait_for_selector('#chip-link[data-level=good]')
        self.until('document.getElementById("chip-mode").textContent === "SAFE"')

    def until(self, expression: str) -> None:
        """Wait until an expression is true in the page."""
        # Playwright's own wait needs `eval` in the page, which the page forbids.
        self.wait(lambda: self.page.evaluate(expression), expression)

    def wait(self, happened: Callable[[], Any], what: str) -> None:
        """Wait until a condition is true."""
        deadline = time.monotonic() + TIMEOUT_MS / 1000
        while not happened():
            assert time.monotonic() < deadline, (
                f'{what} did not happen; the page shows {self.page.inner_text("body")}')
            self.page.wait_for_timeout(POLL_MS)

    def grab(self, right: float, up: float) -> None:
        """Take the stick with the mouse, and push it by parts of its radius; hold it."""
        box = self.page.locator('#stick').bounding_box()
        x, y = box['x'] + box['width'] / 2, box['y'] + box['height'] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        reach = box['width'] / 2
        self.page.mouse.move(x + right * reach, y - up * reach, steps=3)

    def resize(self, width: int, height: int) -> None:
        """Make the window larger or smaller."""
        self.page.set_viewport_size({'width': width, 'height': height})

    def text(self, selector: str) -> str:
        """Return the text of an element."""
        return str(self.page.locator(selector).inner_text())

    def evaluate(self, expression: str, argument: Any = None) -> Any:
        """Return the value of an expression, or of a function of the argument, in the page."""
        return self.page.evaluate(expression, argument)

    def leave(self) -> None:
        """Show nothing any more, and forget cookies; fail if the page has complained."""
        self.page.goto('about:blank')
        self._context.clear_cookies()
        errors, self.errors = self.errors, []
        assert not errors, errors
