"""What the host can set: wheels, LEDs, low side drivers, digital outputs, infrared."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from ... import oi
from ...oi import DriverBits, LedBits, OutputBits, Radius
from ...oi.commands import DUTY
from ..body import Body

MM = 1000.0
STRAIGHT = (0, Radius.STRAIGHT, Radius.STRAIGHT_7FFF)
"""A radius of 0 is in the manual's range but says nothing; it is taken as straight (guess)."""


class Lights(NamedTuple):
    """The LEDs: two that are on or off, and Power, 0 green to 255 red, 0 off to 255 bright."""

    bits: LedBits = LedBits(0)
    color: int = 0
    intensity: int = 0


DARK = Lights()


class Wheels(NamedTuple):
    """What the wheels were told, mm/s."""

    right: float = 0.0
    left: float = 0.0

    @property
    def forward(self) -> float:
        """Speed of the robot's centre, mm/s."""
        return (self.right + self.left) / 2

    def radius(self, separation: float) -> float:
        """Return the radius of the circle that the centre follows; all in mm, straight is inf."""
        turn = abs(self.right - self.left)
        return abs(self.forward) * separation / turn if turn else float('inf')


def steer(velocity: int, radius: int, separation: float) -> Wheels:
    """Return the wheel speeds of a Drive command (manual: Drive); mm/s and mm."""
    if radius in STRAIGHT:
        return Wheels(velocity, velocity)
    if radius == Radius.IN_PLACE_CLOCKWISE:
        return Wheels(-velocity, velocity)
    if radius == Radius.IN_PLACE_COUNTER_CLOCKWISE:
        return Wheels(velocity, -velocity)
    outward = velocity * separation / 2 / radius
    return Wheels(velocity + outward, velocity - outward)


class ActuatorState:
    """What was asked for last, handed on to the body."""

    __slots__ = ('velocity', 'radius', 'right', 'left', 'wheels', 'lights', 'outputs', 'duties',
                 'infrared_sent', '_body', '_separation')

    def __init__(self, body: Body) -> None:
        self._body = body
        self._separation = body.config.encoder_separation * MM
        self.infrared_sent: deque[int] = deque(maxlen=64)
        """The characters that Send IR sent, the newest last."""
        self.reset()

    def reset(self) -> None:
        """Be as after power-on."""
        self.velocity = self.radius = self.right = self.left = 0
        self.outputs = OutputBits(0)
        self.lights = DARK
        self.turn_wheels(Wheels())
        self.switch_drivers(0, 0, 0)

    def obey(self, command: oi.Command) -> None:
        """Do what a command says that is in range; others are not for the actuators."""
        match command:
            case oi.Drive(velocity=velocity, radius=radius):
                self.drive(velocity, radius)
            case oi.DriveDirect(right=right, left=left):
                self.drive_direct(right, left)
            case oi.Leds(bits=bits, color=color, intensity=intensity):
                self.lights = Lights(LedBits(bits), color, intensity)
            case oi.DigitalOutputs(bits=bits):
                self.outputs = OutputBits(bits)
            case oi.LowSideDrivers(bits=bits):
                self.switch_drivers(*(DUTY.high if bits & bit else 0 for bit in DriverBits))
            case oi.PwmLowSideDrivers(driver_0=driver_0, driver_1=driver_1, driver_2=driver_2):
                self.switch_drivers(driver_0, driver_1, driver_2)
            case oi.SendIr(byte=byte):
                self.infrared_sent.append(byte)

    def drive(self, velocity: int, radius: int) -> None:
        """Obey Drive: packets 39 and 40 change, 41 and 42 stay."""
        self.velocity, self.radius = velocity, radius
        self.turn_wheels(steer(velocity, radius, self._separation))

    def drive_direct(self, right: int, left: int) -> None:
        """Obey Drive Direct: packets 41 and 42 change, 39 and 40 stay."""
        self.right, self.left = right, left
        self.turn_wheels(Wheels(right, left))

    def turn_wheels(self, wheels: Wheels) -> None:
        """Turn the wheels for whatever reason."""
        self.wheels = wheels
        self._body.drive(right=wheels.right / MM, left=wheels.left / MM)

    def switch_drivers(self, driver_0: int, driver_1: int, driver_2: int) -> None:
        """Set the duty cycles of the low side drivers, in 128ths."""
        self.duties = (driver_0, driver_1, driver_2)
        full = DUTY.high
        self._body.low_side(
            duty0=driver_0 / full, duty1=driver_1 / full, duty2=driver_2 / full)

    def moves_into_cliff(self) -> bool:
        """Tell whether a cliff matters (manual: Safe Mode): forwards, or on a small radius."""
        wheels = self.wheels
        if wheels.forward > 0:
            return True
        moving = wheels != Wheels()
        return moving and wheels.radius(self._separation) < self._body.config.body_radius * MM

    @property
    def requested(self) -> dict[str, int]:
        """Packets 39 to 42."""
        return {
            'requested_velocity': self.velocity, 'requested_radius': self.radius,
            'requested_right_velocity': self.right, 'requested_left_velocity': self.left,
        }
