# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Who may open the page, and how much each page may send. Pure: the time is an argument."""

from __future__ import annotations

from dataclasses import dataclass
import hmac
from ipaddress import ip_address
from urllib.parse import urlsplit

MOST_VIEWERS = 8
"""Pages that are connected at once."""
LONGEST_MESSAGE = 4096
"""Bytes of one message from a page."""
RATE, BURST = 60.0, 120.0
"""Messages a second that a page may send for long, and at once."""


def is_loopback(host: str) -> bool:
    """Return whether an address, or the name `localhost`, means this computer only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'


def host_of(header: str) -> str:
    """Return the host in a Host header, without its port; '' if it cannot be read."""
    try:
        return urlsplit(f'//{header}').hostname or ''
    except ValueError:
        return ''


@dataclass(frozen=True)
class Access:
    """
    Decides which requests are answered.

    Without a token, only names of this computer are answered: a page of another site can point a
    name of its own at 127.0.0.1, and would then count as the same site (DNS rebinding).
    """

    token: str | None = None

    def admits_host(self, header: str) -> bool:
        """Return whether the Host header of a request is one that we answer."""
        return self.token is not None or is_loopback(host_of(header))

    def admits_token(self, given: str) -> bool:
        """Return whether the token is right; the time this takes does not tell how far it was."""
        # A header may hold bytes that are no UTF-8.
        raw = given.encode('utf-8', 'surrogateescape')
        return self.token is None or hmac.compare_digest(raw, self.token.encode())

    @staticmethod
    def same_origin(origin: str, host: str) -> bool:
        """Return whether the page that connects was served by us; browsers always send both."""
        try:
            parts = urlsplit(origin)
        except ValueError:
            return False
        return parts.scheme in ('http', 'https') and bool(host) and parts.netloc == host


class MessageBudget:
    """Limits how often a page sends messages: RATE a second, and BURST at once."""

    def __init__(self, now: float) -> None:
        """Begin with a full budget."""
        self._left, self._at = BURST, now

    def spend(self, now: float) -> bool:
        """Count a message; return whether it is within the limit."""
        self._left = min(BURST, self._left + (now - self._at) * RATE)
        self._at = now
        if self._left < 1:
            return False
        self._left -= 1
        return True
