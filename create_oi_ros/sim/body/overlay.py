# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Sensor values that somebody outside holds in place of the physics."""

import math
from typing import Any

from .sensed import checked, Sensed


class Overlay:
    """Values by field of `Sensed`, each until a time in seconds."""

    __slots__ = ('_values', '_ends')

    def __init__(self) -> None:
        # Fields differ in type; `checked` has given each value its field's type.
        self._values: dict[str, Any] = {}
        self._ends: dict[str, float] = {}

    @property
    def deadline(self) -> float:
        """When the next value ends; inf: never."""
        return min(self._ends.values(), default=math.inf)

    def force(self, values: dict[str, int], until: float) -> None:
        """Hold all of these values, or with a ValueError none."""
        good = {name: checked(name, value) for name, value in values.items()}
        self._values.update(good)
        self._ends.update(dict.fromkeys(good, until))

    def release(self, names: tuple[str, ...]) -> None:
        """Stop holding the named fields; ValueError for a name that is no field."""
        for name in names:
            checked(name, 0)
        for name in names:
            self._values.pop(name, None)
            self._ends.pop(name, None)

    def release_all(self) -> None:
        """Stop holding anything."""
        self._values.clear()
        self._ends.clear()

    def expire(self, now: float) -> None:
        """Release the values whose time is over."""
        self.release(tuple(name for name, end in self._ends.items() if end <= now))

    def over(self, sensed: Sensed) -> Sensed:
        """Return the sensor values with the held ones in their place."""
        return sensed._replace(**self._values) if self._values else sensed
