# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The physical constants of the simulated Create, in one place, each with what it rests on.

`manual` marks what the Open Interface manual says, `reported` what users of real robots measured,
and `guess` what nobody we know of has published: chosen to be plausible, and here to be changed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from enum import Enum
import math
from typing import Any

from ...robot import BODY_RADIUS, FIRMWARE_SEPARATION, TOP_SPEED, WHEEL_RADIUS, WHEEL_SEPARATION
from ..numbers import number
from .battery import BatteryConfig
from .wheels import MOST_UNSTEADY, Response, TimeConstant, WheelLog


class EncoderSign(Enum):
    """How the single-channel encoders decide which way a wheel turned."""

    DRIVE = 'drive'
    """The sign of the speed that the motor was last driven at, kept at rest: a request counts once
    its dead time is over (measured of Create 2 robots, and the default)."""
    UNTIL_REST = 'until_rest'
    """The last command's sign at once; a command of zero keeps it until the wheel rests, then up
    (guess)."""
    COMMAND = 'command'
    """The last command's sign at once, and up for a command of zero, whatever the wheel does."""
    TRUE = 'true'
    """The true sign, as two-channel encoders would have it."""


class Contact(Enum):
    """What the drive wheels do when an obstacle stops the robot."""

    SLIP = 'slip'
    """They slip on the floor: the encoders count on (default)."""
    STALL = 'stall'
    """They stop with the robot: the encoders stop, and the wheels draw too much current."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyConfig:
    """
    Physical constants of a Create: SI units; `right`/`left` as seen by the robot itself.

    The defaults are what a first-generation Create most likely is (docs/simulator.md).
    """

    wheel_separation: float = 0.262
    """Between the wheels' contact points, metres (measured of one Create: 0.261 to 0.263)."""
    encoder_separation: float = 0.262
    """The separation by which the firmware works out the angle, metres (guess: the true one)."""
    wheel_radius: float = WHEEL_RADIUS
    """Metres (reported: 0.033 to 0.036); for drawings, the physics knows only metres of travel."""
    body_radius: float = BODY_RADIUS
    """Metres (reported: diameter 330 mm)."""
    max_wheel_speed: float = TOP_SPEED
    """Metres per second (manual)."""
    response: Response = Response.FIRST_ORDER
    """How a wheel's speed follows its goal (measured of one Create)."""
    time_constant: TimeConstant = TimeConstant(0.2256, 1.0)
    """Of a first-order wheel, or one over the natural frequency of a second-order one. Times the
    speed it is the way that a wheel coasts: 15 mm, from 0.3 s at 50 mm/s to 0.03 s at 500
    (measured of one Create: 13 mm at 50 and 76 mm/s; reported of others: 15 to 22 mm, 100 to
    500 mm/s)."""
    overshoot: float = 0.2
    """Part of a step by which a second-order wheel goes beyond it (Create 2: 0 to 0.4)."""
    wheel_acceleration: float = 1.0
    """Acceleration of a wheel that ramps, m/s^2 (guess)."""
    braking: float = 1.0
    """How many times as fast a wheel brakes as it speeds up (guess)."""
    dead_time: float = 0.025
    """Seconds until a wheel begins to follow a request (guess that fits the reports of Creates;
    Create 2: 0.03 to 0.06)."""
    dead_band: float = 0.01
    """Slowest speed that moves a wheel, m/s (reported of the 400 series)."""
    encoder_tick: float = 0.00027
    """Metres of travel a count; 0 counts without steps (reported of the 400 series)."""
    encoder_sign: EncoderSign = EncoderSign.DRIVE
    right_speed_gain: float = 1.0
    """Speed that the right wheel settles at, over the speed asked; the encoder sees it."""
    left_speed_gain: float = 1.0
    right_speed_offset: float = 0.0
    """Speed that the right wheel adds to any it is asked, m/s (some Create 2: up to 0.014)."""
    left_speed_offset: float = 0.0
    speed_jitter: float = 0.0
    """Part by which a wheel's mean speed strays from one second to the next, standard deviation
    (Create 2: 0.004 to 0.025, some more when slow; the Create that was filmed: too little to
    see)."""
    speed_wander: float = 0.0
    """The same of a drift within half a minute (Create 2: 0 to 0.05)."""
    right_wheel_scale: float = 1.0
    """True travel of the right wheel over the travel its encoder counts (an unequal wheel)."""
    left_wheel_scale: float = 1.0
    right_slip: float = 0.0
    """Part of the right wheel's travel that is lost to slip at all times, 0 to 1."""
    left_slip: float = 0.0
    contact: Contact = Contact.SLIP
    cliffs_while_charging: bool = False
    """All four cliff sensors see a cliff while a charger's current flows (reported of some)."""
    battery: BatteryConfig = BatteryConfig()
    recording: WheelLog | None = None
    """Wheels that turn as a log says, whatever is asked of them."""
    wheel_lateral: float = WHEEL_SEPARATION / 2
    """Distance of each wheel from the robot's centre line, where its drop switch looks, metres."""
    caster_forward: float = 0.13
    """Distance of the front caster ahead of the centre, metres (guess)."""

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, float) and not math.isfinite(value):
                raise ValueError(f'{each.name} is {value}: it must be finite')
        for name in ('wheel_separation', 'encoder_separation', 'body_radius',
                     'max_wheel_speed', 'wheel_acceleration', 'braking'):
            if getattr(self, name) <= 0:
                raise ValueError(f'{name} is {getattr(self, name)}: it must be above 0')
        for name in ('dead_time', 'dead_band', 'encoder_tick'):
            if getattr(self, name) < 0:
                raise ValueError(f'{name} is {getattr(self, name)}: it must not be below 0')
        if self.time_constant.seconds <= 0:
            raise ValueError(f'time_constant is {self.time_constant.seconds}: it must be above 0')
        if not 0 <= self.overshoot < 1:
            raise ValueError(f'overshoot is {self.overshoot}: it must be within 0 to 1')
        for name in ('speed_jitter', 'speed_wander'):
            if not 0 <= getattr(self, name) <= MOST_UNSTEADY:
                raise ValueError(f'{name} is {getattr(self, name)}: '
                                 f'it must be within 0 to {MOST_UNSTEADY:g}')
        for name in ('right_slip', 'left_slip'):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f'{name} is {getattr(self, name)}: it must be within 0 to 1')


CENTRE = BodyConfig()
"""The centre of what was measured and reported: the default robot."""
IDEAL = BodyConfig(
    wheel_separation=WHEEL_SEPARATION, encoder_separation=FIRMWARE_SEPARATION,
    response=Response.RAMP, dead_time=0.0, dead_band=0.0, encoder_tick=0.0,
    encoder_sign=EncoderSign.UNTIL_REST)
"""Wheels that ramp without delay, for tests whose sums are easy."""


TIME_CONSTANT = {
    'time_constant': 'seconds', 'time_constant_exponent': 'exponent',
    'time_constant_slowest': 'slowest', 'time_constant_fastest': 'fastest'}
"""Names of guesses, and the fields of the time constant that they set."""
RECORDING = 'recording'
"""The name of the guess that is a file: a log of real wheels."""


def guess_names() -> tuple[str, ...]:
    """Return the names of all guesses about the body."""
    plain = (field.name for field in fields(BodyConfig)
             if isinstance(getattr(CENTRE, field.name), (float, Enum)))
    return (*plain, *TIME_CONSTANT, RECORDING)


def parse_guesses(
    texts: Sequence[str], read: Callable[[str], str],
) -> tuple[BodyConfig, list[str]]:
    """
    Read 'name=value' texts; return the body, and the texts that are about something else.

    `read` returns what a file contains.
    """
    config, rest, known = CENTRE, [], guess_names()
    for text in texts:
        name, _, value = text.partition('=')
        if name not in known:
            rest.append(text)
        elif name in TIME_CONSTANT:
            constant = config.time_constant._replace(
                **{TIME_CONSTANT[name]: _number(name, value)})
            config = replace(config, time_constant=constant)
        elif name == RECORDING:
            config = replace(config, recording=_recording(value, read))
        else:
            changed: dict[str, Any] = {name: _value(name, value)}
            config = replace(config, **changed)
    return config, rest


def _value(name: str, text: str) -> float | Enum:
    default = getattr(CENTRE, name)
    return choice(name, text, type(default)) if isinstance(default, Enum) else _number(name, text)


def choice(name: str, text: str, kind: type[Enum]) -> Enum:
    """Read the value of a guess that is one of several; ValueError says which."""
    try:
        return kind(text)
    except ValueError:
        allowed = ', '.join(str(each.value) for each in kind)
        raise ValueError(f'{name}={text}: one of {allowed} is wanted') from None


def _number(name: str, text: str) -> float:
    try:
        return number(text)
    except ValueError as error:
        raise ValueError(f'{name}: {error}') from None


def _recording(text: str, read: Callable[[str], str]) -> WheelLog:
    try:
        return WheelLog.parse(read(text))
    except (OSError, KeyError) as error:
        raise ValueError(f'{RECORDING}={text}: {error}') from None
