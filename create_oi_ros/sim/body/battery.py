# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The battery, what charges it and what discharges it.

The shapes are documented, the numbers guessed: twelve NiMH cells. The voltage follows the charge
by a table and drops over an inner resistance. The pack is warmed by its own losses, and by a
charge current once it is full.

A charger starts with RECONDITIONING (a small current) when the pack is nearly empty. FULL_CHARGING
follows until the pack is full, then TRICKLE for a time, then WAITING without current until enough
charge is used. A pack that is too hot waits as well. A fault stops charging until it is cleared.
"""

from collections.abc import Sequence
from itertools import pairwise
import math

from ...oi import ChargingState

CAPACITY = 2.7
"""Ampere hours (reported: the yellow pack's 3.0 nominal reads 2.6 to 2.7)."""
INITIAL_LEVEL = 0.9
"""Part of the capacity that is stored at the start."""
CURVE = ((0.0, 12.0), (0.05, 13.8), (0.2, 14.6), (0.8, 15.3), (0.95, 15.8), (1.0, 16.4))
"""Volts without load by part of the capacity, straight lines between (guess)."""
RESISTANCE = 0.2
"""Ohms (guess)."""
ELECTRONICS, STANDBY = 0.2, 0.002
"""Amperes while the robot is on, and while it is off (guesses)."""
CHARGE_CURRENTS = {ChargingState.RECONDITIONING: 0.25, ChargingState.FULL_CHARGING: 1.25,
                   ChargingState.TRICKLE: 0.05}
"""Amperes in each state in which the charger gives any (guesses)."""
RECONDITIONING_BELOW, RECHARGE_BELOW = 0.05, 0.9
"""Parts of the capacity at which reconditioning ends, and at which WAITING does (guesses)."""
TRICKLE_TIME = 3600.0
"""Seconds (guess)."""
AMBIENT, HOT, COOLER = 24.0, 45.0, 5.0
"""Degrees Celsius of the room; at which charging waits, until it is so much cooler (guesses)."""
WARMING, WARMING_TIME = 6.0, 1800.0
"""Degrees that each watt of heat leads to in the long run; time constant, seconds (guesses)."""
LOW_SIDE_LIMITS = (0.5, 0.5, 1.5)
"""Highest current of low side drivers 0, 1 and 2, amperes (manual)."""


class Battery:
    """Charge in ampere hours, current in amperes (negative discharging), temperature in °C."""

    def __init__(self) -> None:
        self.charge = CAPACITY * INITIAL_LEVEL
        self.current = 0.0
        self.temperature = AMBIENT
        self.state = ChargingState.NOT_CHARGING
        self.fault = False
        """Set from outside: the battery refuses to be charged."""
        self.waits = False
        """Set from outside: a charger waits, whatever is left of the charge."""
        self._trickled = 0.0
        self._hot = False

    @property
    def voltage(self) -> float:
        """Volts at the terminals, at the present current."""
        return _voltage_without_load(self.charge / CAPACITY) + self.current * RESISTANCE

    def step(self, dt: float, drawn: float, charger: bool) -> None:
        """Let dt seconds pass while `drawn` amperes are used; `charger`: one is connected."""
        self.state = self._next_state() if charger else ChargingState.NOT_CHARGING
        given = CHARGE_CURRENTS.get(self.state, 0.0)
        # A charger that works also feeds the robot; one that waits or has failed does not.
        self.current = given if given else -drawn
        charge = self.charge + self.current * dt / 3600
        heat = self.current ** 2 * RESISTANCE
        if charge >= CAPACITY:
            heat += given * self.voltage
        self.charge = min(CAPACITY, max(0.0, charge))
        self._trickled = self._trickled + dt if self.state is ChargingState.TRICKLE else 0.0
        goal = AMBIENT + WARMING * heat
        self.temperature += (goal - self.temperature) * -math.expm1(-dt / WARMING_TIME)

    def _next_state(self) -> ChargingState:
        """Return the charging state while a charger is connected."""
        level = self.charge / CAPACITY
        self._hot = self.temperature > HOT - (COOLER if self._hot else 0)
        if self.fault:
            return ChargingState.FAULT
        filled = self.state is ChargingState.WAITING and level > RECHARGE_BELOW
        if self.waits or self._hot or filled:
            return ChargingState.WAITING
        if level < RECONDITIONING_BELOW:
            return ChargingState.RECONDITIONING
        stays_full = self.state is ChargingState.TRICKLE and level > RECHARGE_BELOW
        if level < 1 and not stays_full:
            return ChargingState.FULL_CHARGING
        return ChargingState.WAITING if self._trickled >= TRICKLE_TIME else ChargingState.TRICKLE


def _voltage_without_load(level: float) -> float:
    """Return volts at a part of the capacity, 0 to 1."""
    for (low, bottom), (high, top) in pairwise(CURVE):
        if level <= high:
            return bottom + (top - bottom) * (level - low) / (high - low)
    return CURVE[-1][1]


class Electrics:
    """The battery and everything connected to it. Amperes; duty cycles 0 to 1."""

    def __init__(self) -> None:
        self.battery = Battery()
        self.on = self.charging_allowed = self.base_powered = True
        self.charger = self.docked = False
        self.duties: Sequence[float] = (0.0, 0.0, 0.0)
        """Of low side drivers 0, 1 and 2."""
        self.loads: Sequence[float] = (0.0, 0.0, 0.0)
        """What is connected to them: amperes that each draws when fully on."""

    @property
    def home_base(self) -> bool:
        """The robot touches a Home Base that has power."""
        return self.docked and self.base_powered

    @property
    def overloads(self) -> list[bool]:
        """Whether drivers 0, 1, 2 are on with a load that wants more than the limit."""
        return [duty > 0 and load > limit
                for load, duty, limit in zip(self.loads, self.duties, LOW_SIDE_LIMITS)]

    def step(self, dt: float, motors: float) -> None:
        """Let dt seconds pass while the wheels' motors draw this many amperes."""
        drivers = sum(min(load, limit) * duty for load, duty, limit in zip(
            self.loads, self.duties, LOW_SIDE_LIMITS)) if any(self.loads) else 0.0
        drawn = motors + drivers + (ELECTRONICS if self.on else STANDBY)
        self.battery.step(dt, drawn, self.charging_allowed and (self.charger or self.home_base))
