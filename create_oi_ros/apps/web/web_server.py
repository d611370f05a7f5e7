# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Answers browsers: the page's files, the question for the token, the live connection."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
import hmac
from importlib import resources
from logging import getLogger, LogRecord
import socket
import ssl

from aiohttp import web
from aiohttp.http import HttpProcessingError

from ... import pages
from .access import names_this_computer
from .bag_recording import BagRecording
from .viewers import Viewers

TYPES = {'html': 'text/html', 'css': 'text/css', 'js': 'text/javascript',
         'svg': 'image/svg+xml', 'png': 'image/png', 'webmanifest': 'application/manifest+json'}
HEADERS = {
    # Nothing but our own files runs here, and no other site shows this page inside of its own.
    'Content-Security-Policy': (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'self'; "
        "frame-ancestors 'none'"),
    'X-Content-Type-Options': 'nosniff',
    'Referrer-Policy': 'no-referrer',
    'Cache-Control': 'no-store',
    'Server': 'create_web',  # without a version
}
COOKIE_AGE = 30 * 24 * 3600
"""Seconds for which a browser keeps the token."""
IDLE_TIME = 15.0
"""Seconds after which an idle connection is closed."""
ASK, PAGE = 'token.html', 'index.html'
OPEN = ('/', '/token.html', '/base.css', '/style.css', '/icon.svg', '/icon.png',
        '/page.webmanifest')
"""What needs no token: the question for it, and what that or a home screen needs."""
REPORT = 'report.html'
REPORT_POLICY = "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; " \
                "style-src 'unsafe-inline'; img-src data:"
"""A report shows texts of a bag: its scripts run, but as those of another site."""


def is_ours(record: LogRecord) -> bool:
    """Return whether a log record is about this program, not about bad HTTP that somebody sent."""
    return not (record.exc_info and isinstance(record.exc_info[1], HttpProcessingError))


class WebServer:
    """The routes, and who may use them."""

    def __init__(self, token: str | None, viewers: Viewers, recording: BagRecording,
                 listener: socket.socket, tls: ssl.SSLContext | None) -> None:
        """Serve these viewers; its port keeps the cookies of several servers apart."""
        self._token, self._viewers, self._recording = token, viewers, recording
        self._listener, self._tls = listener, tls
        self._cookie = f'create_web_{listener.getsockname()[1]}'
        self._files = {name: text.encode() for name, text in pages.files().items()}
        for each in (resources.files(__package__) / 'page').iterdir():
            self._files[each.name] = each.read_bytes()

    async def serve(self) -> web.AppRunner:
        """Answer who connects to the socket; return what ends that."""
        application = web.Application(middlewares=[self._guard])
        application.add_routes([web.get('/', self._page), web.get('/live', self._live),
                                web.get('/{name}', self._file)])
        getLogger('aiohttp.server').addFilter(is_ours)
        runner = web.AppRunner(application, access_log=None, keepalive_timeout=IDLE_TIME)
        await runner.setup()
        await web.SockSite(runner, self._listener, ssl_context=self._tls).start()
        return runner

    def _admits(self, token: str) -> bool:
        """Return whether a token is right; it is too long to be guessed, however often."""
        # A header may hold bytes that are no UTF-8.
        raw = token.encode('utf-8', 'surrogateescape')
        return self._token is None or hmac.compare_digest(raw, self._token.encode())

    def _known(self, request: web.Request) -> bool:
        return self._admits(request.cookies.get(self._cookie, ''))

    @web.middleware
    async def _guard(
        self, request: web.Request,
        handler: Callable[[web.Request], Awaitable[web.StreamResponse]],
    ) -> web.StreamResponse:
        """Refuse names that are not ours and who has no token, and add the headers."""
        if self._token is None and not names_this_computer(request.headers.get('Host', '')):
            raise web.HTTPForbidden(text='open this page as http://localhost:PORT\n')
        try:
            if request.path not in OPEN and not self._known(request):
                raise web.HTTPUnauthorized(text='open the address with the token first\n')
            response = await handler(request)
        except web.HTTPException as error:
            error.headers.update(HEADERS)
            raise
        if not response.prepared:
            response.headers.update({**HEADERS, **response.headers})
        return response

    async def _page(self, request: web.Request) -> web.StreamResponse:
        """Send the page; with the right token in the address, keep it in a cookie first."""
        given = request.query.get('token')
        if given is not None and self._token is not None:
            if not self._admits(given):
                raise web.HTTPSeeOther('/#wrong')  # so that it leaves the address bar
            to_page = web.HTTPSeeOther('/')
            to_page.set_cookie(self._cookie, given, max_age=COOKIE_AGE, httponly=True,
                               samesite='Lax', secure=self._tls is not None)
            raise to_page
        if not self._known(request):
            return self._send(ASK, status=401)
        return self._send(PAGE)

    async def _file(self, request: web.Request) -> web.StreamResponse:
        name = request.match_info['name']
        if name == REPORT and self._recording.report:
            body = await asyncio.to_thread(self._recording.report.read_bytes)
            return web.Response(body=body, content_type='text/html', charset='utf-8',
                                headers={'Content-Security-Policy': REPORT_POLICY})
        if name not in self._files:
            raise web.HTTPNotFound(text='no such file\n')
        return self._send(name)

    async def _live(self, request: web.Request) -> web.StreamResponse:
        origin, host = request.headers.get('Origin', ''), request.headers.get('Host', '')
        if not host or origin not in (f'http://{host}', f'https://{host}'):
            raise web.HTTPForbidden(text='only the page of this server may connect\n')
        return await self._viewers.serve(request)

    def _send(self, name: str, status: int = 200) -> web.Response:
        return web.Response(body=self._files[name], status=status, charset='utf-8',
                            content_type=TYPES[name.rpartition('.')[2]])
