"""
The battery: a bucket of charge with a voltage, a temperature and the charger's four stages.

Documented shapes, guessed numbers: twelve NiMH cells; voltage follows charge by a table and sags
by an inner resistance; the pack warms by what it burns and by a full charge going nowhere.

A charger begins with RECONDITIONING when the pack is nearly empty (a small current), goes on with
FULL until the pack is full, then TRICKLE for a while, then WAITING without current until enough
has been used.  A pack that is too hot waits too.  A fault stops all of it until it is cleared.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
import math

from .sensed import Charging

LONGEST_PIECE = 1.0
"""Seconds."""
CURVE = ((0.0, 12.0), (0.05, 13.8), (0.2, 14.6), (0.8, 15.3), (0.95, 15.8), (1.0, 16.4))
"""Volts at rest by fraction of capacity, straight lines between (guess)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryConfig:
    """Amperes, ampere hours, ohms, degrees Celsius, seconds.  All guesses but the capacity."""

    capacity: float = 2.7
    """Ampere hours (reported: the yellow pack's 3.0 nominal reads 2.6 to 2.7)."""
    initial_charge: float = 0.9
    """Fraction of the capacity at the start."""
    resistance: float = 0.2
    electronics: float = 0.2
    """Amperes while the robot is on."""
    standby: float = 0.002
    """Amperes while it is off."""
    wheel_idle: float = 0.08
    """Amperes of one turning wheel's motor, and, below, what speed adds per m/s."""
    wheel_per_speed: float = 0.3
    wheel_blocked: float = 0.8
    """Amperes of a wheel that slips against an obstacle: below the limit of 1 A (manual)."""
    wheel_stalled: float = 1.5
    """Amperes of a wheel that is held: above it."""
    full_current: float = 1.25
    reconditioning_current: float = 0.25
    trickle_current: float = 0.05
    reconditioning_below: float = 0.05
    """Fraction of the capacity."""
    trickle_time: float = 3600.0
    recharge_below: float = 0.9
    """Fraction of the capacity at which WAITING ends."""
    ambient: float = 24.0
    hot: float = 45.0
    """At this temperature charging waits, until it is 5 degrees cooler."""
    warming: float = 6.0
    """Degrees above ambient in the long run, for each watt turned to heat."""
    warming_time: float = 1800.0

    def __post_init__(self) -> None:
        for name in ('capacity', 'warming_time'):
            if not getattr(self, name) > 0:
                raise ValueError(f'{name} is {getattr(self, name)}: it must be above 0')
        if not 0 <= self.initial_charge <= 1:
            raise ValueError(f'initial_charge is {self.initial_charge}: a fraction, 0 to 1')


class Battery:
    """Charge in ampere hours, current in amperes (negative discharging), temperature in °C."""

    __slots__ = ('config', 'charge', 'current', 'temperature', 'state', 'fault',
                 '_trickled', '_hot')

    def __init__(self, config: BatteryConfig) -> None:
        self.config = config
        self.charge = config.capacity * config.initial_charge
        self.current = 0.0
        self.temperature = config.ambient
        self.state = Charging.NOT_CHARGING
        self.fault = False
        """Set from outside: the next charge is refused."""
        self._trickled = 0.0
        self._hot = False

    @property
    def voltage(self) -> float:
        """Volts at the terminals, under the present current."""
        level = self.charge / self.config.capacity
        return _at_rest(min(level, 1.0)) + self.current * self.config.resistance

    def step(self, dt: float, drawn: float, charger: bool) -> None:
        """Let dt seconds pass with `drawn` amperes used and, perhaps, a charger connected."""
        while dt > 0:
            piece = min(dt, LONGEST_PIECE)
            self._piece(piece, drawn, charger)
            dt -= piece

    def _piece(self, dt: float, drawn: float, charger: bool) -> None:
        config = self.config
        self.state = self._next_state() if charger else Charging.NOT_CHARGING
        given = self._given()
        # A charger that works feeds the robot too; one that waits or has failed does not.
        self.current = given if given else -drawn
        charge = self.charge + self.current * dt / 3600
        lost = self.current ** 2 * config.resistance
        if charge >= config.capacity:
            lost += given * self.voltage
            charge = config.capacity
        self.charge = max(0.0, charge)
        self._trickled = self._trickled + dt if self.state is Charging.TRICKLE else 0.0
        goal = config.ambient + config.warming * lost
        self.temperature += (goal - self.temperature) * -math.expm1(-dt / config.warming_time)

    def _given(self) -> float:
        config = self.config
        if self.state is Charging.FULL:
            return config.full_current
        if self.state is Charging.RECONDITIONING:
            return config.reconditioning_current
        return config.trickle_current if self.state is Charging.TRICKLE else 0.0

    def _next_state(self) -> Charging:
        """Work out the stage of a connected charger."""
        config, level = self.config, self.charge / self.config.capacity
        self._hot = self.temperature > config.hot - (5 if self._hot else 0)
        if self.fault:
            return Charging.FAULT
        if self._hot:
            return Charging.WAITING
        if self.state is Charging.WAITING and level > config.recharge_below:
            return Charging.WAITING
        if level < config.reconditioning_below:
            return Charging.RECONDITIONING
        if level < 1 and not (self.state is Charging.TRICKLE and level > config.recharge_below):
            return Charging.FULL
        return (Charging.WAITING if self._trickled >= config.trickle_time else Charging.TRICKLE)


def _at_rest(level: float) -> float:
    """Return the volts without load at a fraction of the capacity, 0 to 1."""
    for (low, bottom), (high, top) in pairwise(CURVE):
        if level <= high:
            return bottom + (top - bottom) * (level - low) / (high - low)
    return CURVE[-1][1]
