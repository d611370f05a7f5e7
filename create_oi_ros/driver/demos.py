"""The robot's own demos: it plays them in Passive, where it does not obey velocities."""

from .. import oi
from .motion import Motion
from .outbox import Outbox
from .requests import Reply, Requests
from .supervision import Supervision

END_DEMO = oi.Demo(demo=oi.DemoNumber.ABORT)
DOCK_PAUSE = 1.0
"""Seconds that the robot is to be in Passive before it is sent to its dock (reported)."""


class Demos:
    """Starts and ends demos; Passive is the wanted mode from then on."""

    def __init__(
        self, outbox: Outbox, requests: Requests, supervision: Supervision, motion: Motion,
    ) -> None:
        self._outbox = outbox
        self._requests = requests
        self._supervision = supervision
        self._motion = motion

    def start(self, demo: oi.DemoNumber, reply: Reply) -> None:
        """Let the robot play a demo; the reply comes when it has been told."""
        refusal = self._requests.refusal(oi.Demo)
        if demo is oi.DemoNumber.ABORT:
            refusal = 'no demo: call stop_demo to end one'
        if refusal:
            reply(False, refusal)
            return
        self._motion.stop()
        self._supervision.want(oi.Mode.PASSIVE)
        if demo is oi.DemoNumber.COVER_AND_DOCK and self._drives:
            self._outbox.send(oi.Start(), pause=DOCK_PAUSE)
        self._requests.send(
            oi.Demo(demo=demo), reply, f'demo {demo.name} runs; call stop_demo to end it')

    def stop(self, reply: Reply) -> None:
        """End the demo that runs, if any; the robot stays in Passive."""
        if self._drives and not self._requests.refusal(oi.Demo):
            reply(True, 'no demo runs: the robot obeys cmd_vel')
        else:
            self._requests.send(
                END_DEMO, reply, 'demo ended; call set_mode with SAFE to drive again')

    @property
    def _drives(self) -> bool:
        return self._supervision.status.actual in oi.ACTUATE
