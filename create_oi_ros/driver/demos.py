# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot's built-in demos: it plays them in Passive, where it follows no velocity commands."""

from collections.abc import Callable

from .. import oi
from .outbox import Outbox
from .pending import done, Pending, refused
from .requests import Requests
from .state import Owner, State, StateEvent
from .stopping import END_DEMO
from .supervision import Supervision

DOCK_PAUSE = 1.0
"""Seconds that the robot must be in Passive before it is sent to its dock (reported)."""


class Demos:
    """Starts and ends demos; Passive is the wanted mode from then on."""

    def __init__(
        self, outbox: Outbox, requests: Requests, state: State, supervision: Supervision,
        handle: Callable[[StateEvent], None],
    ) -> None:
        """`handle` passes an event to the driver's state."""
        self._outbox = outbox
        self._requests = requests
        self._state = state
        self._supervision = supervision
        self._handle = handle

    def start(self, demo: oi.DemoNumber) -> Pending:
        """Let the robot play a demo; the request ends when the command is written."""
        if demo is oi.DemoNumber.ABORT:
            return refused('no demo: call stop_demo to end one')
        why = self._requests.refusal(oi.Demo)
        if why is not None:
            return refused(why)
        can_drive = self._supervision.status.can_drive
        self._handle(StateEvent.DEMO_STARTED)
        self._supervision.want(oi.Mode.PASSIVE)
        if demo is oi.DemoNumber.COVER_AND_DOCK and can_drive:
            self._outbox.send(oi.Start(), pause=DOCK_PAUSE)
        return self._requests.send(
            oi.Demo(demo=demo), f'demo {demo.name} sent; call stop_demo to end it')

    def seek_dock(self) -> None:
        """Let the robot look for its dock, for a goal."""
        can_drive = self._supervision.status.can_drive
        self._handle(StateEvent.DOCKING_STARTED)
        self._supervision.want(oi.Mode.PASSIVE)
        if can_drive:
            self._outbox.send(oi.Start(), pause=DOCK_PAUSE)
        self._outbox.send(oi.Demo(demo=oi.DemoNumber.COVER_AND_DOCK))

    def stop(self) -> Pending:
        """End the demo that runs, if any; the robot stays in Passive."""
        why = self._requests.refusal(oi.Demo)
        if why is not None:
            return refused(why)
        if self._state.owner is not Owner.ROBOT and self._supervision.status.can_drive:
            return done('no demo runs: the robot obeys cmd_vel')
        self._handle(StateEvent.DEMO_ENDED)
        return self._requests.send(
            END_DEMO, 'end of the demo sent; call set_mode with SAFE to drive again')
