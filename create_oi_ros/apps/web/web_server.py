# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Answers browsers: the page's files, the question for the token, the live connection."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from importlib import resources

from aiohttp import web

from ... import pages
from .access import Access
from .viewers import Viewers

TYPES = {'.html': 'text/html', '.css': 'text/css', '.js': 'text/javascript',
         '.svg': 'image/svg+xml'}
HEADERS = {
    # Nothing but our own files runs here, and no other site shows this page inside of its own.
    'Content-Security-Policy': (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"),
    'X-Content-Type-Options': 'nosniff',
    'Referrer-Policy': 'no-referrer',
    'Cache-Control': 'no-store',
}
COOKIE_AGE = 30 * 24 * 3600
"""Seconds for which a browser keeps the token."""
MOST_BODY = 1024
"""Bytes of a request's body; no request here needs one."""
ASK, PAGE = 'token.html', 'index.html'
OPEN = ('token.html', 'base.css', 'style.css', 'icon.svg')
"""Files that the question for the token needs."""


def files() -> dict[str, tuple[bytes, str]]:
    """Return the page's files, and those that all pages share, with their types, by name."""
    folder = resources.files(__package__) / 'page'
    found = {each.name: each.read_bytes() for each in folder.iterdir()}
    found |= {name: text.encode() for name, text in pages.files().items()}
    return {name: (body, TYPES['.' + name.rpartition('.')[2]]) for name, body in found.items()}


class WebServer:
    """The routes, and who may use them."""

    def __init__(self, access: Access, viewers: Viewers, port: int) -> None:
        """Serve these viewers; `port` keeps the cookies of several servers apart."""
        self._access, self._viewers = access, viewers
        self._cookie = f'create_web_{port}'
        self._files = files()

    def application(self) -> web.Application:
        """Return the application."""
        made = web.Application(middlewares=[self._guard], client_max_size=MOST_BODY)
        made.router.add_get('/', self._page)
        made.router.add_get('/live', self._live)
        made.router.add_get('/{name}', self._file)
        return made

    def _known(self, request: web.Request) -> bool:
        return self._access.admits_token(request.cookies.get(self._cookie, ''))

    @web.middleware
    async def _guard(
        self, request: web.Request,
        handler: Callable[[web.Request], Awaitable[web.StreamResponse]],
    ) -> web.StreamResponse:
        """Refuse names that are not ours, and add the headers."""
        if not self._access.admits_host(request.headers.get('Host', '')):
            raise web.HTTPForbidden(text='open this page as http://localhost:PORT\n')
        try:
            response = await handler(request)
        except web.HTTPException as error:
            error.headers.update(HEADERS)
            raise
        if not response.prepared:
            response.headers.update(HEADERS)
        return response

    async def _page(self, request: web.Request) -> web.StreamResponse:
        """Send the page; with the right token in the address, keep it in a cookie first."""
        given = request.query.get('token')
        if given is not None and self._access.token is not None:
            if not self._access.admits_token(given):
                return self._send(ASK, status=403)
            to_page = web.HTTPSeeOther('/')
            to_page.set_cookie(self._cookie, given, max_age=COOKIE_AGE, httponly=True,
                               samesite='Lax')
            raise to_page
        if not self._known(request):
            return self._send(ASK, status=401)
        return self._send(PAGE)

    async def _file(self, request: web.Request) -> web.StreamResponse:
        name = request.match_info['name']
        if name not in self._files:
            raise web.HTTPNotFound(text='no such file\n')
        if name not in OPEN and not self._known(request):
            raise web.HTTPUnauthorized(text='open the address with the token first\n')
        return self._send(name)

    async def _live(self, request: web.Request) -> web.StreamResponse:
        if not self._known(request):
            raise web.HTTPUnauthorized(text='open the address with the token first\n')
        origin, host = request.headers.get('Origin', ''), request.headers.get('Host', '')
        if not self._access.same_origin(origin, host):
            raise web.HTTPForbidden(text='only the page of this server may connect\n')
        return await self._viewers.serve(request)

    def _send(self, name: str, status: int = 200) -> web.Response:
        body, type_ = self._files[name]
        return web.Response(body=body, status=status, content_type=type_, charset='utf-8')
