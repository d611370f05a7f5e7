# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What charges and discharges the battery: electronics, motors, low side drivers, chargers."""

from collections.abc import Iterator, Sequence

from .battery import Battery, BatteryConfig

LOW_SIDE_LIMITS = (0.5, 0.5, 1.5)
"""Highest current of low side drivers 0, 1 and 2, amperes (manual)."""


class Electrics:
    """The battery and everything connected to it. Amperes; duty cycles 0 to 1."""

    __slots__ = ('battery', 'on', 'charging_allowed', 'charger', 'base_powered', 'docked',
                 'duties', 'loads')

    def __init__(self, config: BatteryConfig) -> None:
        self.battery = Battery(config)
        self.on = self.charging_allowed = self.base_powered = True
        self.charger = self.docked = False
        self.duties: Sequence[float] = (0.0, 0.0, 0.0)
        self.loads: Sequence[float] = (0.0, 0.0, 0.0)

    @property
    def home_base(self) -> bool:
        """The robot touches a Home Base that has power."""
        return self.docked and self.base_powered

    def step(self, dt: float, motors: float) -> None:
        """Let dt seconds pass while the wheels' motors draw this many amperes."""
        config = self.battery.config
        drawn = motors + (config.electronics if self.on else config.standby)
        for load, duty, limit in self._drivers():
            drawn += min(load, limit) * duty
        self.battery.step(dt, drawn, self.charging_allowed and (self.charger or self.home_base))

    def overloads(self) -> list[bool]:
        """Return whether drivers 0, 1, 2 are on with a load that wants more than the limit."""
        return [duty > 0 and load > limit for load, duty, limit in self._drivers()]

    def _drivers(self) -> Iterator[tuple[float, float, float]]:
        """Return each low side driver's load, duty cycle and limit."""
        return zip(self.loads, self.duties, LOW_SIDE_LIMITS, strict=True)
