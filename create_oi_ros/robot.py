# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The Create's own numbers, each once. SI units unless a name says otherwise.

What the Open Interface puts on the wire (opcodes, packets, ranges of fields) is declared in `oi`.
"""

from enum import Enum
from typing import Final

MILLI: Final = 1e-3
"""Metres in a millimetre, volts in a millivolt, seconds in a millisecond."""
MM_PER_M: Final = 1000
"""Millimetres in a metre."""
SLOT: Final = 0.015
"""Seconds between two updates of the robot's sensors, and between two stream frames."""
TOP_SPEED_MM: Final = 500
"""Fastest that either wheel may be told to run, mm/s (manual: Drive Direct)."""
TOP_SPEED: Final = TOP_SPEED_MM * MILLI
"""The same, m/s."""
BATTERY_MILLIVOLTS: Final = range(6_000, 25_000 + 1)
"""What the battery of a robot that runs can have: twelve cells of half a volt at least; the
charger gives 22.5 V."""
BATTERY_MILLIAMPS: Final = range(-10_000, 10_000 + 1)
"""Motors and outputs stay below: a wheel may draw 1 A, the low side drivers 2.5 A, the cargo bay
1.5 A (manual: Overcurrents; Cargo Bay Connector)."""
BATTERY_DEGREES: Final = range(-40, 100 + 1)
"""Degrees Celsius in which robot and battery survive (guess)."""
MOST_CAPACITY: Final = 10_000
"""Milliampere-hours; the largest battery packs that are sold for the robot have half of that."""
MOST_CHARGE: Final = 1.2
"""Fraction of its capacity that a battery can hold: real robots report a little more than all."""
FIRMWARE_SEPARATION: Final = 0.258
"""Metres between the wheels that the firmware assumes when it reports an angle (reported)."""
WHEEL_SEPARATION: Final = 0.258
"""Metres between the wheels' contact points (reported: 0.258 to 0.262)."""
WHEEL_RADIUS: Final = 0.033
"""Metres (reported: 0.033 to 0.036)."""
BODY_RADIUS: Final = 0.165
"""Metres (reported: a diameter of 0.33)."""
CLIFF_BEARINGS: Final = (60, 15, -15, -60)
"""Degrees to the left at which the cliff sensors sit, seen from the centre (guess): left, front
left, front right, right."""
BUMPER_BEARING: Final = 45
"""Degrees to the left of the middle of the bumper's left half; the right half mirrors it."""


class Rounding(Enum):
    """What the robot does, when it is read, with the part of a sum that is no whole unit."""

    TRUNCATE = 'truncate'
    """Towards zero; the rest is lost (reported of real robots)."""
    ROUND = 'round'
    """To the nearest, halves away from zero; the rest, of either sign, is lost."""
    CARRY = 'carry'
    """Towards zero; the rest stays for the next reading."""
