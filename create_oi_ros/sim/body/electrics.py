# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What charges and discharges the battery: electronics, motors, low side drivers, chargers."""

from collections.abc import Sequence

from .battery import Battery, BatteryConfig

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
