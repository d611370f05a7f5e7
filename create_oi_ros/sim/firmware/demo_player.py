# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Starts, advances and stops the demos, for commands and for the buttons."""

from ...oi import DemoNumber
from ..body.sensed import Sensed
from .demo_behaviors import Controls, Demo, DEMOS

ENDED = object()
"""Returned by `next` when a demo has ended."""


class DemoPlayer:
    """Runs one demo at a time."""

    __slots__ = ('demo', '_behaviour', '_controls', '_selected', '_pressed')

    def __init__(self, controls: Controls) -> None:
        self._controls = controls
        self.demo: DemoNumber | None = None
        """The demo that runs."""
        self._behaviour: Demo | None = None
        self.reset()

    def reset(self) -> None:
        """Return to the state after power-on."""
        self._selected = DemoNumber.COVER
        self._pressed = (False, False)
        self.stop()

    def start(self, demo: DemoNumber) -> None:
        """Start a demo in place of the one that runs."""
        self.stop()
        self.demo = demo
        self._behaviour = DEMOS[demo](self._controls)

    def stop(self) -> None:
        """End the demo that runs, if any, and stop the wheels."""
        if self.demo is not None:
            self._controls.drive(0, 0)
        self.demo = self._behaviour = None

    def step(self) -> None:
        """Advance the demo by a slot."""
        if self._behaviour is not None and next(self._behaviour, ENDED) is ENDED:
            self.stop()

    def watch_buttons(self, sensed: Sensed, *, enabled: bool) -> None:
        """Look at the buttons: if enabled, Advance selects a demo, Play starts and stops it."""
        before, self._pressed = self._pressed, (sensed.play, sensed.advance)
        if not enabled:
            return
        if sensed.advance and not before[1]:
            numbers = list(DEMOS)
            self._selected = numbers[(numbers.index(self._selected) + 1) % len(numbers)]
        if sensed.play and not before[0]:
            if self.demo is None:
                self.start(self._selected)
            else:
                self.stop()
