# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A real Chromium without a window, driven by Playwright."""

from collections.abc import Callable
import time
from typing import Any

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
