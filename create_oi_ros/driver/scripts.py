"""
Scripts in the robot: stored, played, read back.

While a script waits the robot hears nothing, a stop included, and it does not say when it is
done. So the driver calls: every so often it sends a stop and asks for a list of packets that it
asks for at no other time. A frame of that list shows that the robot hears again, and that the
wheels stand.

A stored script is told of by bare bytes between frames. So the stream is halted, the line falls
silent, and all that comes next is taken for the script.
"""

from collections.abc import Callable
from enum import Enum

from .. import oi
from ..oi.script import can_end, commands_of, open_waits, SCRIPT_LIMIT, script_of_reply
from ..oi.tools.text import format_command
from .motion import Motion
from .outbox import Outbox
from .requests import Reply, Requests
from .script_speeds import asked_directly, CLEARED, Echoes, Speeds
from .stream_plan import StreamPlan

CALL_EVERY = 0.2
"""Seconds between two calls to a robot that plays a script."""
HUSH = 0.1
"""Seconds after which the line is silent once the stream was halted."""
PATIENCE = 0.5
"""Seconds that the robot may take to begin to tell its script."""
DRIVES = 'the robot drives, and could not be told to stop meanwhile: stop it first'

ShowReply = Callable[[bool, str, bytes], None]
"""Takes whether the script could be read, if not why, and its bytes."""


class Doing(Enum):
    """What keeps the robot from its stream or its commands."""

    NOTHING = 'nothing'
    PLAYING = 'playing'
    HUSHING = 'waiting for silence'
    READING = 'reading'


class Scripts:
    """The script that the robot stores, as far as it is known."""

    def __init__(
        self, outbox: Outbox, requests: Requests, motion: Motion,
        plan: Callable[[], StreamPlan],
    ) -> None:
        """Take where commands go, what checks them, the wheels, and the present stream plan."""
        self._outbox = outbox
        self._requests = requests
        self._motion = motion
        self._plan = plan
        self._stored: oi.Script | None = None
        self._echoes = Echoes(None, 0.0, cleared=False)
        self._doing = Doing.NOTHING
        self._due = 0.0
        self._told = bytearray()
        self._show_reply: ShowReply | None = None

    @property
    def playing(self) -> bool:
        """Whether a script may be playing, so that commands may not be heard."""
        return self._doing is Doing.PLAYING

    @property
    def recounts(self) -> bool:
        """Whether the script that played last has set distance and angle to zero."""
        return self._echoes.recounts

    def speeds(self, readings: oi.Readings) -> Speeds | None:
        """Return what the wheels were asked for, by the driver or a script, if it can be told."""
        if not self.playing:
            return asked_directly(readings)
        return self._echoes.speeds(readings) if self._echoes.tell else None

    @property
    def reading(self) -> bool:
        """Whether the script is being read, so that no frames come."""
        return self._doing in (Doing.HUSHING, Doing.READING)

    @property
    def refusal(self) -> str:
        """Why nothing can be asked for now; '' if it can."""
        if self._doing is Doing.NOTHING:
            return ''
        if self.playing:
            return 'a script plays, and the robot hears nothing while it waits: try again later'
        return 'the stored script is being read: try again'

    def define(self, script: oi.Script, reply: Reply) -> None:
        """Store a script; an empty one clears it."""
        try:
            commands_of(script)
        except ValueError as error:
            reply(False, str(error))
            return
        if self._requests.send(script, reply, _described(script)):
            self._stored = script

    def play(self, now: float, reply: Reply, *, force: bool) -> None:
        """Play the stored script; one that cannot end, or is not known, only by force."""
        refusal = self._requests.refusal(oi.PlayScript) or ('' if force else self._doubt())
        if self._stored == oi.Script(script=b''):
            refusal = 'no script is stored: call define_script'
        if not self._motion.at_rest:
            refusal = DRIVES
        if refusal:
            reply(False, refusal)
            return
        self._outbox.send(CLEARED)
        self._outbox.send(oi.Stream(packets=self._plan().script.ids))
        if self._requests.send(oi.PlayScript(), reply, 'script plays'):
            self._echoes = Echoes(
                self._stored, self._motion.limits.wheel_separation,
                cleared=not self._requests.refusal(oi.Drive))
            self._doing, self._due = Doing.PLAYING, now + CALL_EVERY

    def show(self, now: float, reply: ShowReply) -> None:
        """Ask the robot for its script."""
        refusal = self._requests.refusal(oi.ShowScript)
        if not self._motion.at_rest:
            refusal = DRIVES
        if refusal:
            reply(False, refusal, b'')
            return
        self._outbox.send(oi.PauseResumeStream(state=oi.StreamState.PAUSE))
        self._doing, self._due, self._show_reply = Doing.HUSHING, now + HUSH, reply

    def poll(self, now: float) -> None:
        """Do what time asks for."""
        if self._doing is Doing.HUSHING and self._outbox.busy:
            self._due = now + HUSH
        if self._doing is Doing.NOTHING or now < self._due or self._outbox.busy:
            return
        if self._doing is Doing.PLAYING:
            self._outbox.send(oi.DriveDirect(right=0, left=0))
            self._outbox.send(oi.Stream(packets=self._plan().marker.ids))
            self._due = now + CALL_EVERY
        elif self._doing is Doing.HUSHING:
            self._told.clear()
            self._outbox.send(oi.ShowScript())
            slowest = (1 + SCRIPT_LIMIT) * oi.BITS_PER_BYTE / self._plan().baud
            self._doing, self._due = Doing.READING, now + PATIENCE + slowest
        else:
            self._end_show(False, f'the robot told {len(self._told)} bytes of its script and '
                           'then nothing: try again')

    def take(self, received: bytes) -> bool:
        """Take bytes that may be of the script; False where they are of frames."""
        if self._doing is not Doing.READING:
            return False
        self._told += received
        if self._told and len(self._told) > self._told[0]:
            self._read()
        return True

    def heard(self, packets: oi.PacketList) -> bool:
        """Take note of a frame; True if it shows that a script has ended."""
        if not self.playing or packets != self._plan().marker:
            return False
        self._doing = Doing.NOTHING
        self._plan().restart()
        return True

    def lost(self) -> None:
        """Note that no robot answers: it may have been switched off, and forgotten its script."""
        self._stored = None
        if self.reading:
            self._end_show(False, 'the robot was lost while it told its script')
        self._doing = Doing.NOTHING

    def _doubt(self) -> str:
        if self._stored is None:
            return ('the stored script is not known: call define_script, or show_script to see '
                    'what it is, or set force')
        if not can_end(self._stored):
            return ('the stored script plays itself again and cannot end, nor can the robot be '
                    'stopped but by its power button: set force to play it')
        return ''

    def _read(self) -> None:
        try:
            script = script_of_reply(bytes(self._told))
            script.encode()
        except ValueError as error:
            self._end_show(False, f'the reply came damaged ({error}): try again')
            return
        self._stored = script
        self._end_show(True, _described(script), script.script)

    def _end_show(self, success: bool, message: str, script: bytes = b'') -> None:
        reply, self._show_reply = self._show_reply, None
        self._doing = Doing.NOTHING
        self._plan().restart()
        if reply is not None:
            reply(success, message, script)


def _described(script: oi.Script) -> str:
    """Say what there is to know of a script before it is played."""
    if not script.script:
        return 'no script is stored'
    said = f'{len(script.script)} of {SCRIPT_LIMIT} bytes'
    waits = ', '.join(format_command(wait) for wait in open_waits(script))
    if not can_end(script):
        return f'{said}; it plays itself again and cannot end'
    return f'{said}; it ends only if this happens: {waits}' if waits else said
