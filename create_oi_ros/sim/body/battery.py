# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The battery: a store of charge with a voltage, a temperature and the charger's four stages.

The shapes are documented, the numbers guessed: twelve NiMH cells. The voltage follows the charge
by a table and drops over an inner resistance. The pack is warmed by its own losses, and by a
charge current once it is full.

A charger starts with RECONDITIONING (a small current) when the pack is nearly empty. FULL_CHARGING
follows until the pack is full, then TRICKLE for a time, then WAITING without current until enough
charge is used. A pack that is too hot waits as well. A fault stops charging until it is cleared.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
import math

from ...oi import ChargingState

LONGEST_STEP = 1.0
"""Seconds that are computed at once."""
CURVE = ((0.0, 12.0), (0.05, 13.8), (0.2, 14.6), (0.8, 15.3), (0.95, 15.8), (1.0, 16.4))
"""Volts without load by fraction of capacity, straight lines between (guess)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryConfig:
    """
    Constants of the battery; all but the capacity are guesses.

    Amperes, ampere hours, ohms, degrees Celsius, seconds.
    """

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
    """Amperes of the motor of a wheel that turns slowly."""
    wheel_per_speed: float = 0.3
    """Amperes that each m/s of wheel speed adds."""
    wheel_blocked: float = 0.8
    """Amperes of a wheel that slips against an obstacle: below the limit of 1 A (manual)."""
    wheel_stalled: float = 1.5
    """Amperes of a wheel that is held: above that limit."""
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
    """Charging waits at this temperature, until the pack is 5 degrees cooler."""
    warming: float = 6.0
    """Degrees above ambient that each watt of heat leads to in the long run."""
    warming_time: float = 1800.0

    def __post_init__(self) -> None:
        for name in ('capacity', 'warming_time'):
            if not getattr(self, name) > 0:
                raise ValueError(f'{name} is {getattr(self, name)}; allowed: above 0')
        if not 0 <= self.initial_charge <= 1:
            raise ValueError(f'initial_charge is {self.initial_charge}; allowed: 0 to 1')


class Battery:
    """Charge in ampere hours, current in amperes (negative discharging), temperature in °C."""

    __slots__ = ('config', 'charge', 'current', 'temperature', 'state', 'fault',
                 '_trickled', '_hot')

    def __init__(self, config: BatteryConfig) -> None:
        self.config = config
        self.charge = config.capacity * config.initial_charge
        self.current = 0.0
        self.temperature = config.ambient
        self.state = ChargingState.NOT_CHARGING
        self.fault = False
        """Set from outside: the battery refuses to be charged."""
        self._trickled = 0.0
        self._hot = False

    @property
    def voltage(self) -> float:
        """Volts at the terminals, at the present current."""
        level = self.charge / self.config.capacity
        return _at_rest(min(level, 1.0)) + self.current * self.config.resistance

    def step(self, dt: float, drawn: float, charger: bool) -> None:
        """Let dt seconds pass while `drawn` amperes are used; `charger`: one is connected."""
        while dt > 0:
            part = min(dt, LONGEST_STEP)
            self._step(part, drawn, charger)
            dt -= part

    def _step(self, dt: float, drawn: float, charger: bool) -> None:
        config = self.config
        self.state = self._next_state() if charger else ChargingState.NOT_CHARGING
        given = self._given()
        # A charger that works also feeds the robot; one that waits or has failed does not.
        self.current = given if given else -drawn
        charge = self.charge + self.current * dt / 3600
        lost = self.current ** 2 * config.resistance
        if charge >= config.capacity:
            lost += given * self.voltage
            charge = config.capacity
        self.charge = max(0.0, charge)
        self._trickled = self._trickled + dt if self.state is ChargingState.TRICKLE else 0.0
        goal = config.ambient + config.warming * lost
        self.temperature += (goal - self.temperature) * -math.expm1(-dt / config.warming_time)

    def _given(self) -> float:
        config = self.config
        if self.state is ChargingState.FULL_CHARGING:
            return config.full_current
        if self.state is ChargingState.RECONDITIONING:
            return config.reconditioning_current
        return config.trickle_current if self.state is ChargingState.TRICKLE else 0.0

    def _next_state(self) -> ChargingState:
        """Return the charging state while a charger is connected."""
        config, level = self.config, self.charge / self.config.capacity
        self._hot = self.temperature > config.hot - (5 if self._hot else 0)
        if self.fault:
            return ChargingState.FAULT
        if self._hot:
            return ChargingState.WAITING
        if self.state is ChargingState.WAITING and level > config.recharge_below:
            return ChargingState.WAITING
        if level < config.reconditioning_below:
            return ChargingState.RECONDITIONING
        stays_full = self.state is ChargingState.TRICKLE and level > config.recharge_below
        if level < 1 and not stays_full:
            return ChargingState.FULL_CHARGING
        if self._trickled >= config.trickle_time:
            return ChargingState.WAITING
        return ChargingState.TRICKLE


def _at_rest(level: float) -> float:
    """Return the volts without load at a fraction of the capacity, 0 to 1."""
    for (low, bottom), (high, top) in pairwise(CURVE):
        if level <= high:
            return bottom + (top - bottom) * (level - low) / (high - low)
    return CURVE[-1][1]


LOW_SIDE_LIMITS = (0.5, 0.5, 1.5)
"""Highest current of low side drivers 0, 1 and 2, amperes (manual)."""


class Electrics:
    """The battery and everything connected to it. Amperes; duty cycles 0 to 1."""

    __slots__ = ('battery', 'on', 'charging_allowed', 'charger', 'base_powered', 'docked',
                 'overloads', '_duties', '_loads', '_drivers_draw')

    def __init__(self, config: BatteryConfig) -> None:
        self.battery = Battery(config)
        self.on = self.charging_allowed = self.base_powered = True
        self.charger = self.docked = False
        self._duties: Sequence[float] = (0.0, 0.0, 0.0)
        self._loads: Sequence[float] = (0.0, 0.0, 0.0)
        self._note_drivers()

    @property
    def home_base(self) -> bool:
        """The robot touches a Home Base that has power."""
        return self.docked and self.base_powered

    def step(self, dt: float, motors: float) -> None:
        """Let dt seconds pass while the wheels' motors draw this many amperes."""
        config = self.battery.config
        electronics = config.electronics if self.on else config.standby
        drawn = motors + electronics + self._drivers_draw
        self.battery.step(dt, drawn, self.charging_allowed and (self.charger or self.home_base))

    def switch(self, duties: Sequence[float]) -> None:
        """Set the duty cycles of low side drivers 0, 1 and 2."""
        self._duties = duties
        self._note_drivers()

    def load(self, loads: Sequence[float]) -> None:
        """Set what is connected to them: amperes that each draws when fully on."""
        self._loads = loads
        self._note_drivers()

    def _note_drivers(self) -> None:
        drivers = list(zip(self._loads, self._duties, LOW_SIDE_LIMITS, strict=True))
        self._drivers_draw = sum(min(load, limit) * duty for load, duty, limit in drivers)
        self.overloads = [duty > 0 and load > limit for load, duty, limit in drivers]
        """Whether drivers 0, 1, 2 are on with a load that wants more than the limit."""
