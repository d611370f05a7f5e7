# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the Create does with each byte, by the manual.

`Create` is the mirror image of the host's driver and has the same verbs: `receive` bytes, `poll`
up to a time, fetch `data_to_send`. The caller says what time it is, in seconds. Everything but
the bytes happens in the slots, about 15 ms long, in which a Create updates its values, so it does
not matter how often `poll` is called. Bytes take effect when they arrive, between two slots. No
bytes raise.

    create = Create(Body(world))
    create.receive(oi.Start().encode(), 0.0)
    create.poll(1.0)
    sent = create.data_to_send()
"""

from random import Random

from ... import oi
from ...oi import Mode
from ...oi.commands import ACTUATORS, INPUTS, WAITS
from .. import TOLERANCE
from ..body import Body
from ..body.sensed import Sensed
from . import script_waits as scripts
from . import sensing
from .actuators import ActuatorState, DARK, Lights, Speaker, STANDING
from .demo_behaviors import Controls, DemoPlayer
from .guesses import accepted_command, DEFAULT_GUESSES, Guesses
from .uart import BANNER, Uart

RESET_OPCODE = b'\x07'
"""Undocumented; reported to restart the robot."""
FULL = 0.98
"""Part of the capacity from which on a battery counts as full."""
CHUNK = 256
"""Bytes that are interpreted at once, so that the cost of a flood only grows with its length."""


class Create:
    """A Create's electronics: switched on, boot loader finished, Open Interface off."""

    def __init__(self, body: Body, *, checksum: oi.Checksum = oi.Checksum.HARDWARE,
                 guesses: Guesses = DEFAULT_GUESSES, seed: int = 0) -> None:
        self.body = body
        self.guesses = guesses
        self.period = guesses.frame_period
        """Seconds of a slot, on the robot's clock."""
        self.actuators = ActuatorState(body)
        self.commands = 0
        """Complete commands received so far, obeyed or not."""
        self.time = 0.0
        """Seconds on the robot's clock: whole slots since the first `poll` or `receive`."""
        self._slots = 0
        self._epoch: float | None = None
        self._uart = Uart(overrun=guesses.overrun, buffer=guesses.transmit_buffer)
        self.powered = True
        """Whether the robot is switched on."""
        self._boot_end = 0.0
        self._telemetry = sensing.Telemetry(body, checksum)
        self._demos = DemoPlayer(Controls(body, self.actuators, Random(seed)))
        self._reset()

    def _reset(self) -> None:
        self.mode = Mode.OFF
        self.script = b''
        self._queue = oi.CommandReader()
        """What the host sent."""
        self._script_rest = oi.CommandReader()
        """What is left of the script that plays."""
        self._next_round: int | None = None
        """The slot in which a script that has played itself starts again."""
        self._unread = b''
        """Bytes of a command that arrives while a wait lasts, if requests are answered then."""
        self._wait: scripts.Over | None = None
        self._telemetry.reset()
        self._demos.reset()
        self.actuators.reset()
        self.speaker = Speaker()
        self.body.allow_charging(True)

    # The serial line.

    def receive(self, data: bytes, now: float, baud: int | None = None) -> None:
        """
        Take bytes that the host sent, at `now` seconds.

        `baud` is the host's rate; if it is not the robot's, both sides receive garbage.
        """
        self.poll(now)
        self._uart.host_baud = baud
        for start in range(0, len(data), CHUNK):
            self._read(data[start:start + CHUNK])

    def data_to_send(self) -> bytes:
        """Return the bytes that the robot has sent since the last call."""
        return self._uart.take()

    @property
    def baud(self) -> int:
        """The robot's rate, bits per second."""
        return self._uart.baud

    def host_baud(self, baud: int | None) -> None:
        """Set the host's rate before it sends anything; None: the same as the robot's."""
        self._uart.host_baud = baud

    def _read(self, data: bytes) -> None:
        if not self._running:
            return
        data = self._uart.receive(data, self.time)
        if self._input_waits:
            self._enqueue(data)
        else:
            self._queue.feed(data)
            self._execute_queue()

    @property
    def _input_waits(self) -> bool:
        """Whether bytes wait: for a wait command, or for the end of a script that has none."""
        return self._wait is not None or (
            self._next_round is not None and not self.guesses.loop_listens)

    def _enqueue(self, data: bytes) -> None:
        """Queue bytes until the wait is over, as many as fit; the others are lost."""
        if self.guesses.wait_answers:
            data = self._without_requests(data)
        room = self.guesses.wait_queue - len(self._queue.pending)
        self._queue.feed(data[:max(0, room)])

    def _without_requests(self, data: bytes) -> bytes:
        """Answer the requests for packets; return the bytes of the other commands."""
        reader, others = oi.CommandReader(), b''
        reader.feed(self._unread + data)
        while True:
            self._unread = reader.pending
            event = reader.next_event()
            if event is None:
                return others
            if isinstance(event, oi.Sensors | oi.QueryList):
                self._execute(event)
            else:
                others += self._unread[:len(self._unread) - len(reader.pending)]

    @property
    def waiting(self) -> bool:
        """Whether a wait command keeps the robot from obeying bytes."""
        return self._wait is not None

    @property
    def _booting(self) -> bool:
        return self.time < self._boot_end - TOLERANCE

    @property
    def _running(self) -> bool:
        return self.powered and not self._booting

    def _execute_queue(self) -> None:
        """Obey what is left of the script, then what the host sent, up to a wait."""
        while self._wait is None and self._running:
            scripted = self._script_rest.next_event()
            match self._next_of_line() if scripted is None else scripted:
                case None:
                    if not self._begin_round():
                        return
                case oi.UnknownOpcode(byte):
                    if byte == RESET_OPCODE and self.guesses.opcode_7_resets:
                        self._boot()
                case oi.PlayScript() if self.mode in oi.PlayScript.modes and self.script:
                    if scripted is None:
                        self._script_rest.feed(self.script)
                    else:
                        # A script that plays itself takes at least one slot for each round.
                        self._next_round = self._slots + 1
                case oi.Command() as command:
                    self._execute(command)

    def _next_of_line(self) -> oi.Command | oi.UnknownOpcode | None:
        """Return the host's next command, behind the script."""
        # A script's last command may take the host's bytes for its data.
        if left := self._script_rest.clear():
            behind = self._queue.clear()
            self._queue.feed(left + behind)
        return None if self._input_waits else self._queue.next_event()

    def _begin_round(self) -> bool:
        """Play the script again if it has played itself, and its time has come."""
        if self._next_round is None or self._slots < self._next_round:
            return False
        self._next_round = None
        self._script_rest.feed(self.script)
        return True

    # Time.

    def poll(self, now: float) -> None:
        """Advance to `now`, in seconds; the first call sets the start of the robot's clock."""
        if self._epoch is None:
            self._epoch = now
        due = int((now - self._epoch) / self.period + TOLERANCE)
        while self._slots < due:
            self._slot()

    def _slot(self) -> None:
        self.body.step(self.period)
        self._slots += 1
        self.time = self._slots * self.period
        self._telemetry.refresh()
        if self.powered and self.body.battery_flat:
            self._switch_off()
        if not self._running:
            return
        sensed = self.body.sense()
        self._check_safety(sensed)
        if self._wait is None:
            self._demos.watch_buttons(sensed, enabled=self.mode not in oi.ACTUATE)
        self._advance()
        if self._telemetry.streaming and (
                self._wait is None or self.guesses.stream_while_waiting):
            self._uart.stream(self._telemetry.frame(self._own_values()), self.time)

    def _advance(self) -> None:
        """Advance the demo and the script by a slot."""
        self._demos.step()
        if self._wait is not None and self._wait():
            self._wait = None
            unread, self._unread = self._unread, b''
            self._queue.feed(unread)
            self._execute_queue()
        elif self._next_round is not None:
            self._execute_queue()

    def _check_safety(self, sensed: Sensed) -> None:
        """Stop for hazards in Safe mode (manual); drop and charger end a demo too (guess)."""
        guarded = self.mode is Mode.SAFE or self.demo is not None
        if not guarded:
            return
        charger = sensed.internal_charger or (
            self.guesses.dock_ends_safe and sensed.home_base)
        edge = (self.mode is Mode.SAFE and scripts.cliff(sensed)
                and self.actuators.moves_into_cliff())
        if charger or edge or scripts.wheel_drop(sensed):
            if self.mode is Mode.SAFE:
                self._enter(Mode.PASSIVE)
            self._demos.stop()

    def _held_by_dock(self) -> bool:
        """Return whether the robot stays on its Home Base, as Safe mode may have it."""
        sensed = self.body.sense()
        return (self.guesses.dock_holds_safe and self.mode is Mode.SAFE and sensed.home_base
                and sensed.charge < FULL * sensed.capacity)

    # Power and buttons.

    def power(self, on: bool, now: float) -> None:
        """Switch the robot on or off; with an empty battery it stays off."""
        self.poll(now)
        if on and not self.powered and not self.body.battery_flat:
            self._boot()
        elif not on and self.powered:
            self._switch_off()

    def _switch_off(self) -> None:
        self.powered = False
        self._reset()
        self.body.power(False)

    def lose_battery(self, now: float) -> None:
        """Take the battery out and put it back: the robot restarts if it was on."""
        self.poll(now)
        if self.powered:
            self._boot()

    def _boot(self) -> None:
        self._reset()
        self.body.power(True)
        self.powered = True
        self._boot_end = self.time + self.guesses.boot_seconds
        self._uart.reset(self.time)
        if self.guesses.banner:
            self._uart.reply(BANNER, self.time)

    # Modes and demos.

    def _enter(self, mode: Mode) -> None:
        self._demos.stop()
        if mode is Mode.PASSIVE:
            self.actuators.turn_wheels(STANDING)
            if self.guesses.passive_ends_drivers:
                self.actuators.switch_drivers(0, 0, 0)
        elif mode is Mode.SAFE or self.mode is Mode.PASSIVE:
            self.actuators.lights = DARK
        self.mode = mode
        begins = self.guesses.dock_charges or not self.body.sense().home_base
        self.body.allow_charging(mode is Mode.PASSIVE and begins)

    @property
    def demo(self) -> oi.DemoNumber | None:
        return self._demos.demo

    @property
    def lights(self) -> Lights:
        """The LEDs as they are lit: by the host in Safe and Full, else by the robot (guess)."""
        if not self.powered or self.mode in oi.ACTUATE:
            return self.actuators.lights if self.powered else DARK
        sensed = self.body.sense()
        level = min(1.0, sensed.charge / sensed.capacity) if sensed.capacity else 0.0
        playing = oi.LedBits.PLAY if self.demo is not None else oi.LedBits(0)
        return Lights(playing, round(255 * (1 - level)), 255)

    @property
    def outputs(self) -> oi.OutputBits:
        """The digital outputs; all high while the boot loader runs (manual: Digital Outputs)."""
        if self.powered and self._booting:
            return oi.OutputBits.OUTPUT_0 | oi.OutputBits.OUTPUT_1 | oi.OutputBits.OUTPUT_2
        return self.actuators.outputs

    @property
    def note(self) -> int:
        """The MIDI number of the note that sounds now; 0 for silence."""
        return self.speaker.note(self.time)

    # Commands.

    def _execute(self, command: oi.Command) -> None:
        self.commands += 1
        if self.mode not in command.modes:
            return
        accepted = accepted_command(command, self.guesses)
        if accepted is None:
            return
        if accepted.enters is not None:
            if isinstance(accepted, oi.Start) and self.mode is Mode.OFF:
                self.speaker.beep(self.time)
            self._enter(accepted.enters)
        if accepted.section == ACTUATORS:
            self.actuators.execute(accepted)
            if self._held_by_dock():
                self.actuators.turn_wheels(STANDING)
            self.speaker.execute(accepted, self.time)
        elif accepted.section == INPUTS:
            self._uart.reply(self._telemetry.answer(accepted, self._own_values()), self.time)
        elif accepted.section == WAITS:
            self._begin_wait(accepted)
        else:
            self._execute_other(accepted)

    def _execute_other(self, command: oi.Command) -> None:
        match command:
            case oi.Baud(code=code):
                self._uart.change(oi.BaudCode(code).rate, self.time)
                self._queue.clear()
            case oi.Demo(demo=oi.DemoNumber.ABORT):
                self._demos.stop()
            case oi.Demo(demo=demo):
                self._demos.start(oi.DemoNumber(demo))
            case oi.Cover():
                self._demos.start(oi.DemoNumber.COVER)
            case oi.CoverAndDock():
                self._demos.start(oi.DemoNumber.COVER_AND_DOCK)
            case oi.Spot():
                self._demos.start(oi.DemoNumber.SPOT_COVER)
            case oi.Script(script=script):
                self.script = script
            case oi.ShowScript():
                self._telemetry.streaming = False
                self._uart.reply(bytes([len(self.script)]) + self.script, self.time)

    def _begin_wait(self, command: oi.Command) -> None:
        over = scripts.waiting(
            command, self.body, lambda: self._slots, lambda: self.mode is Mode.PASSIVE)
        if over():
            return
        self._wait = over
        self._enqueue(self._queue.clear())

    def _own_values(self) -> dict[str, int]:
        """Return the values of the packets that do not come from the body."""
        return {
            'oi_mode': self.mode, 'song_number': self.speaker.number,
            'song_playing': self.speaker.song_playing(self.time), **self.actuators.requested,
        }

    @property
    def frames(self) -> int:
        """Stream frames sent so far."""
        return self._telemetry.frames
