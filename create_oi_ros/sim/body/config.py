"""
The physical constants of the simulated Create, in one place, each with what it rests on.

`manual` marks what the Open Interface manual says, `reported` what users of real robots measured,
and `guess` what nobody we know of has published: chosen to be plausible, and here to be changed.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import Enum
import math

from .battery import BatteryConfig


class EncoderSign(Enum):
    """How the single-channel encoders decide which way a wheel turned."""

    UNTIL_REST = 'until_rest'
    """The last command's sign; a command of zero keeps it until the wheel rests, then up (guess).

    Otherwise each stop out of reverse would be counted forwards, which no user has reported.
    """
    COMMAND = 'command'
    """The last command's sign at once, and up for a command of zero, whatever the wheel does."""
    TRUE = 'true'
    """The true sign, as two-channel encoders would have it: for comparison only."""


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

    The defaults are an ideal robot: equal wheels, no slip, speeds as asked.
    """

    wheel_separation: float = 0.258
    """Between the wheels' contact points, metres (reported; others say 0.260)."""
    encoder_separation: float = 0.258
    """The separation by which the firmware works out the angle, metres (guess: the true one)."""
    wheel_radius: float = 0.033
    """Metres (reported: 0.033 to 0.036); for drawings, the physics knows only metres of travel."""
    body_radius: float = 0.165
    """Metres (reported: diameter 330 mm)."""
    max_wheel_speed: float = 0.5
    """Metres per second (manual)."""
    wheel_acceleration: float = 1.0
    """Limit of each wheel's acceleration and braking, m/s^2 (guess)."""
    encoder_sign: EncoderSign = EncoderSign.UNTIL_REST
    right_speed_gain: float = 1.0
    """Speed that the right wheel settles at, over the speed asked; the encoder sees it."""
    left_speed_gain: float = 1.0
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
    wheel_lateral: float = 0.129
    """Distance of each wheel from the robot's centre line, where its drop switch looks, metres."""
    caster_forward: float = 0.13
    """Distance of the front caster ahead of the centre, metres (guess)."""

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, float) and not math.isfinite(value):
                raise ValueError(f'{each.name} is {value}: it must be finite')
        for name in ('wheel_separation', 'encoder_separation', 'body_radius',
                     'max_wheel_speed', 'wheel_acceleration'):
            if getattr(self, name) <= 0:
                raise ValueError(f'{name} is {getattr(self, name)}: it must be above 0')
        for name in ('right_slip', 'left_slip'):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f'{name} is {getattr(self, name)}: it must be within 0 to 1')


IDEAL = BodyConfig()
"""Equal wheels, no slip, the speeds that were asked for."""
