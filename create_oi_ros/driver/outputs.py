# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
LEDs, digital outputs, low side drivers and infrared: sent, and restored.

The robot forgets its LEDs when the mode changes; it keeps the digital outputs. Both are restored.
The low side drivers may turn motors: they are switched off when a robot is found again. The robot
reports none of these: replies say what was sent.
"""

from collections.abc import Sequence

from .. import oi
from ..oi.commands import DUTY
from .core import Core
from .outbox import DRIVERS_OFF, Pending, refused

FULL_DUTY = DUTY.high
"""What turns a low side driver on all the time (manual: PWM Low Side Drivers)."""


class Outputs:
    """What a request can light, switch or send."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self._to_restore: dict[type[oi.Command], oi.Command] = {}
        self._drivers_set = False
        """Whether a low side driver was ever set."""

    def set_leds(self, leds: oi.Leds) -> Pending:
        """Light Play and Advance, and Power in a colour (0 green, 255 red) and intensity."""
        return self._set(leds, 'LEDs sent')

    def set_output(self, name: str, *, high: bool) -> Pending:
        """Set one digital output; the others stay, those that nobody has set are low."""
        outputs = dict(zip(self._core.settings.output_names, oi.OutputBits))
        if name not in outputs:
            return refused(f'no output is called {name!r}; output_names: {", ".join(outputs)}')
        last = self._to_restore.get(oi.DigitalOutputs)
        bits = last.bits if isinstance(last, oi.DigitalOutputs) else 0
        bit = outputs[name]
        return self.set_outputs(oi.OutputBits(bits | bit if high else bits & ~bit))

    def set_outputs(self, bits: oi.OutputBits) -> Pending:
        """Set the digital outputs of the cargo bay."""
        return self._set(oi.DigitalOutputs(bits=bits), 'digital outputs sent')

    def _set(self, command: oi.Command, done: str) -> Pending:
        request = self._core.request(command, done)
        if request.outcome is None:
            self._to_restore[type(command)] = command
        return request

    def set_drivers(self, duties: Sequence[float]) -> Pending:
        """Set the duty cycles of the low side drivers 0, 1 and 2, each 0 to 1."""
        for number, duty in enumerate(duties):
            if not 0 <= duty <= 1:
                return refused(f'driver_{number} = {duty:g}; allowed: 0.0 (off) to 1.0 (on)')
        zero, one, two = (round(duty * FULL_DUTY) for duty in duties)
        request = self._core.request(
            oi.PwmLowSideDrivers(driver_0=zero, driver_1=one, driver_2=two),
            f'low side drivers 0, 1, 2 sent: {zero}, {one}, {two} of {FULL_DUTY}')
        if request.outcome is None:
            self._drivers_set = True
            self._to_restore.pop(oi.PwmLowSideDrivers, None)
        return request

    def switch_drivers_off(self) -> None:
        """Switch the low side drivers off; in Passive the robot obeys that after its next mode."""
        self._core.outbox.send(DRIVERS_OFF)
        if self._drivers_set:
            self._to_restore[oi.PwmLowSideDrivers] = DRIVERS_OFF

    def send_ir(self, character: int) -> Pending:
        """Send an infrared character, 0 to 255."""
        return self._core.request(oi.SendIr(byte=character), f'character {character} sent')

    def restore(self) -> None:
        """Set LEDs and outputs again: the mode has changed, or the robot was switched off."""
        for command in self._to_restore.values():
            self._core.outbox.send(command)
