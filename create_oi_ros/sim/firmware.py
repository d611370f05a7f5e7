"""
What the Create does with each byte, by the manual.

`Create` is the mirror image of the host's driver, with the same verbs: `receive` bytes, `step` to
a time, fetch `data_to_send`.  Time is what the caller says it is, in seconds; inside, everything
happens in the slots of about 15 ms in which a Create updates its values, so it does not matter how
often one steps.  Bytes take effect as they arrive, between two slots.  No bytes raise.

    create = Create(Body(world))
    create.receive(oi.Start().encode(), 0.0)
    create.step(1.0)
    sent = create.data_to_send()
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from create_oi_ros import oi
from create_oi_ros.oi import Mode
from create_oi_ros.oi.commands import ACTUATORS, INPUTS, WAITS
from create_oi_ros.sim import scripts, sensing
from create_oi_ros.sim.actuators import Actuators, DARK, Lights, Wheels
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.demos import Controls, Demo, DEMOS
from create_oi_ros.sim.guesses import Guesses, LIKELY
from create_oi_ros.sim.limits import obeyable
from create_oi_ros.sim.power import BANNER, Power
from create_oi_ros.sim.readings import Readings
from create_oi_ros.sim.songs import BEEP, DESCENDING, Speaker
from create_oi_ros.sim.uart import DEFAULT_BAUD, SLOW_BAUD, Uart

_RESET_OPCODE = b'\x07'
"""Undocumented; reported to restart the robot."""
_CHUNK = 256
"""Bytes read at once, so that a flood costs no more for being long."""
_EARLY = 1e-6
_ENDED = object()


class Create:
    """A Create's electronics: on, booted long ago, its Open Interface off."""

    def __init__(self, body: Body, *, checksum: oi.Checksum = oi.Checksum.HARDWARE,
                 guesses: Guesses = LIKELY, seed: int = 0) -> None:
        self.body = body
        self.guesses = guesses
        self.period = guesses.frame_period
        """Seconds of a slot, on the robot's clock."""
        self.mode = Mode.OFF
        self.actuators = Actuators(body)
        self.speaker = Speaker()
        self.demo: oi.DemoNumber | None = None
        """The demo that runs."""
        self.script = b''
        self.commands = 0
        """Commands that were whole so far, obeyed or not."""
        self._slots = 0
        self._epoch: float | None = None
        self._uart = Uart(overrun=guesses.overrun, buffer=guesses.transmit_buffer)
        self._power = Power()
        self._telemetry = sensing.Telemetry(body, checksum)
        self._controls = Controls(body, self.actuators, Random(seed), self._sound)
        self._forget()

    def _forget(self) -> None:
        """Be as after power-on."""
        self.mode = Mode.OFF
        self.script = b''
        self._queue = oi.CommandReader()
        self._script_plays = False
        self._wait: scripts.Over | None = None
        self._telemetry.forget()
        self._selected = oi.DemoNumber.COVER
        self._pressed = (False, False)
        self._run_demo(None)
        self.actuators.reset()
        self.speaker = Speaker()
        self.body.allow_charging(True)

    # The line.

    def receive(self, data: bytes, now: float, baud: int | None = None) -> None:
        """
        Hear bytes that the host sent, at `now` seconds.

        `baud` is the rate the host is set to; where it is not the robot's, both hear garbage.
        """
        self.step(now)
        self._uart.host_baud = baud
        for start in range(0, len(data), _CHUNK):
            self._hear(data[start:start + _CHUNK])

    def data_to_send(self) -> bytes:
        """Return what the robot has said since the last call."""
        return self._uart.take()

    @property
    def baud(self) -> int:
        """The robot's rate, bits per second."""
        return self._uart.baud

    def host_baud(self, baud: int | None) -> None:
        """Learn of the rate the host is set to before it says anything; None: the right one."""
        self._uart.host_baud = baud

    def _hear(self, data: bytes) -> None:
        if not self._listening:
            return
        data = self._uart.receive(data, self.time)
        while data and self._listening:
            self._queue.feed(data)
            data = self._obey_queue()

    @property
    def _listening(self) -> bool:
        """Manual: Wait Commands, 'nor does it react to any inputs, serial or otherwise'."""
        return self._running and self._wait is None and not self._script_plays

    @property
    def waiting(self) -> bool:
        """Tell whether a wait command makes the robot deaf."""
        return self._wait is not None

    @property
    def _running(self) -> bool:
        return self._power.on and not self._power.booting(self.time)

    def _obey_queue(self) -> bytes:
        """Obey what is in the input queue until it waits; return what a played script put off."""
        put_off = b''
        while self._wait is None and self._running:
            match self._queue.next_event():
                case None:
                    self._script_plays = False
                    return put_off
                case oi.UnknownOpcode(byte):
                    if byte == _RESET_OPCODE and self.guesses.opcode_7_resets:
                        self._boot()
                case oi.PlayScript() if self.mode in oi.PlayScript.modes and self.script:
                    put_off = self._load_script() or put_off
                case oi.Command() as command:
                    self._obey(command)
        return b''

    def _load_script(self) -> bytes:
        """Put the script into the input queue; return the host's bytes that were behind it."""
        behind = self._queue.clear()
        self._queue.feed(self.script)
        if self._script_plays:
            # A script that plays itself again takes at least one slot for a round.
            self._wait = scripts.until_slot(lambda: self._slots, 1)
            return b''
        self._script_plays = True
        return behind

    # Time.

    @property
    def time(self) -> float:
        """Seconds of the robot's own clock: whole slots since the first time it was told."""
        return self._slots * self.period

    def step(self, now: float) -> None:
        """Live on until `now`, in seconds; the first call tells where time begins."""
        if self._epoch is None:
            self._epoch = now
        due = int((now - self._epoch) / self.period + _EARLY)
        while self._slots < due:
            self._slot()

    def _slot(self) -> None:
        self.body.step(self.period)
        self._slots += 1
        self._telemetry.refresh()
        if self._power.on and self.body.battery_flat:
            self._power.default_baud = DEFAULT_BAUD
            self._switch_off()
        if not self._power.on:
            return
        readings = self.body.sense()
        self._watch_baud(readings)
        if not self._running:
            return
        self._stay_safe(readings)
        if self._wait is None:
            self._watch_buttons(readings)
        self._go_on()
        if self._telemetry.streaming and (
                self._wait is None or self.guesses.stream_while_waiting):
            self._uart.stream(self._telemetry.frame(self._own_values()), self.time)

    def _go_on(self) -> None:
        """Let the demo and the script do their next thing."""
        if self._behaviour is not None and next(self._behaviour, _ENDED) is _ENDED:
            self._run_demo(None)
        if self._wait is not None and self._wait():
            self._wait = None
            self._obey_queue()

    def _stay_safe(self, readings: Readings) -> None:
        """Manual: Safe Mode.  A demo heeds a wheel drop and the charger too (guess)."""
        guarded = self.mode is Mode.SAFE or self.demo is not None
        if not guarded:
            return
        charger = readings.internal_charger or (
            self.guesses.dock_ends_safe and readings.home_base)
        edge = (self.mode is Mode.SAFE and scripts.cliff(readings)
                and self.actuators.moves_into_cliff())
        if charger or edge or scripts.wheel_drop(readings):
            if self.mode is Mode.SAFE:
                self._enter(Mode.PASSIVE)
            self._run_demo(None)

    # Power and buttons.

    @property
    def powered(self) -> bool:
        """Tell whether the robot is on."""
        return self._power.on

    def power(self, on: bool, now: float) -> None:
        """Switch the robot on or off with its power button; a flat battery switches nothing on."""
        self.step(now)
        if on and not self._power.on and not self.body.battery_flat:
            self._boot()
        elif not on and self._power.on:
            self._switch_off()

    def _switch_off(self) -> None:
        self._power.on = False
        self._forget()
        self.body.power(False)

    def toggle_power(self, now: float) -> None:
        """Press the power button, or raise pin 3 (manual: 'on a low-to-high transition')."""
        self.power(not self._power.on, now)

    def lose_battery(self, now: float) -> None:
        """Take the battery out and put it back in: on as before, with nothing remembered."""
        self.step(now)
        self._power.default_baud = DEFAULT_BAUD
        if self._power.on:
            self._boot()

    def _boot(self) -> None:
        self._forget()
        self.body.power(True)
        self._power.switch_on(self.time, self.guesses.boot_seconds, self.body.sense().play)
        self._uart.reset(self._power.default_baud, self.time)
        if self.guesses.banner:
            self._uart.reply(BANNER, self.time)

    def _watch_baud(self, readings: Readings) -> None:
        if self._power.play_held(readings.play, self.time):
            self._uart.baud = SLOW_BAUD
            self._sound(DESCENDING)
        if self._power.pin_pulsed(readings.device_detect, self.time):
            self._uart.baud = SLOW_BAUD

    def _watch_buttons(self, readings: Readings) -> None:
        """Without a host's control, Advance chooses a demo and Play plays and stops it."""
        before, self._pressed = self._pressed, (readings.play, readings.advance)
        if self.mode in oi.ACTUATE:
            return
        if readings.advance and not before[1]:
            numbers = list(DEMOS)
            self._selected = numbers[(numbers.index(self._selected) + 1) % len(numbers)]
        if readings.play and not before[0]:
            self._run_demo(self._selected if self.demo is None else None)

    # Modes and demos.

    def _enter(self, mode: Mode) -> None:
        self._run_demo(None)
        if mode is Mode.PASSIVE:
            self.actuators.turn_wheels(Wheels())
            if self.guesses.passive_stops_drivers:
                self.actuators.switch_drivers(0, 0, 0)
        elif mode is Mode.SAFE or self.mode is Mode.PASSIVE:
            self.actuators.lights = DARK
        self.mode = mode
        self.body.allow_charging(mode is Mode.PASSIVE)

    def _run_demo(self, demo: oi.DemoNumber | None) -> None:
        """Begin a demo, or end the one that runs."""
        if self.demo is not None:
            self.actuators.turn_wheels(Wheels())
        self.demo = demo
        self._behaviour: Demo | None = DEMOS[demo](self._controls) if demo is not None else None

    def _sound(self, notes: Sequence[oi.Note]) -> None:
        self.speaker.sound(notes, self.time)

    @property
    def lights(self) -> Lights:
        """The LEDs as they shine: the host's in Safe and Full, else the robot's own (guess)."""
        if not self._power.on or self.mode in oi.ACTUATE:
            return self.actuators.lights if self._power.on else DARK
        readings = self.body.sense()
        level = min(1.0, readings.charge / readings.capacity) if readings.capacity else 0.0
        playing = oi.LedBits.PLAY if self.demo is not None else oi.LedBits(0)
        return Lights(playing, round(255 * (1 - level)), 255)

    @property
    def outputs(self) -> oi.OutputBits:
        """The digital outputs; all high while the boot loader runs (manual: Digital Outputs)."""
        if self._power.on and self._power.booting(self.time):
            return oi.OutputBits.OUTPUT_0 | oi.OutputBits.OUTPUT_1 | oi.OutputBits.OUTPUT_2
        return self.actuators.outputs

    @property
    def note(self) -> int:
        """The MIDI number of the note that sounds now; 0 when all is quiet."""
        return self.speaker.note(self.time)

    # Commands.

    def _obey(self, command: oi.Command) -> None:
        self.commands += 1
        if self.mode not in command.modes:
            return
        accepted = obeyable(command)
        if accepted is None:
            return
        if accepted.enters is not None:
            self._change_mode(accepted, accepted.enters)
        if accepted.section == ACTUATORS:
            self.actuators.obey(accepted)
            self.speaker.obey(accepted, self.time)
        elif accepted.section == INPUTS:
            self._uart.reply(self._telemetry.answer(accepted, self._own_values()), self.time)
        elif accepted.section == WAITS:
            self._begin_wait(accepted)
        else:
            self._obey_other(accepted)

    def _change_mode(self, command: oi.Command, mode: Mode) -> None:
        if isinstance(command, oi.Start):
            if self.mode is Mode.OFF:
                self._sound(BEEP)
            elif self.demo is not None and not self.guesses.start_ends_demo:
                return
        self._enter(mode)

    def _obey_other(self, command: oi.Command) -> None:
        match command:
            case oi.Baud(code=code):
                self._change_baud(oi.BaudCode(code).rate)
            case oi.Demo(demo=demo):
                self._run_demo(None if demo == oi.DemoNumber.ABORT else oi.DemoNumber(demo))
            case oi.Cover():
                self._run_demo(oi.DemoNumber.COVER)
            case oi.CoverAndDock():
                self._run_demo(oi.DemoNumber.COVER_AND_DOCK)
            case oi.Spot():
                self._run_demo(oi.DemoNumber.SPOT_COVER)
            case oi.Script(script=script):
                self.script = script
            case oi.ShowScript():
                self._telemetry.streaming = False
                self._uart.reply(bytes([len(self.script)]) + self.script, self.time)

    def _change_baud(self, baud: int) -> None:
        self._power.default_baud = DEFAULT_BAUD
        self._uart.change(baud, self.time)
        if not self._script_plays:
            self._queue.clear()

    def _begin_wait(self, command: oi.Command) -> None:
        over = scripts.waiting(
            command, self.body, lambda: self._slots, lambda: self.mode is Mode.PASSIVE)
        if over():
            return
        self._wait = over
        if not self._script_plays:
            self._queue.clear()

    def _own_values(self) -> dict[str, int]:
        """Return the values of the packets that are no sensors of the body."""
        return {
            'oi_mode': self.mode, 'song_number': self.speaker.number,
            'song_playing': self.speaker.song_playing(self.time), **self.actuators.requested,
        }

    @property
    def frames(self) -> int:
        """Stream frames sent so far."""
        return self._telemetry.frames
