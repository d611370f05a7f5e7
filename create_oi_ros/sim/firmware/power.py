# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Power-on: the boot loader, the held Play button, and the baud rate that results."""

from ..timing import TOLERANCE
from .uart import BaudPin, DEFAULT_BAUD, SLOW_BAUD

BANNER = (
    b'bl-start\r\n1.2.3\r\nbl-end\r\n'
    b'2006-09-12-1137-L   \r\n'
    b'RDK by iRobot!\r\nMC9S12E128\r\n'
    b'2006-09-12-1137-L\r\n'
    b'battery-current-zero 258\r\n'
    b'assembly 0x02\r\n')
"""Text sent at power-on (reported: about 140 bytes like these; the words are a guess)."""
PLAY_HELD = 4.0
"""Seconds (manual: Serial Port Settings, Method 1)."""


class Power:
    """Whether the robot is on, and its baud rate at power-on. Times on the robot's clock."""

    __slots__ = ('on', 'default_baud', '_boot_end', '_play_since', '_pin')

    def __init__(self) -> None:
        """Start switched on, with the boot loader finished."""
        self.on = True
        self.default_baud = DEFAULT_BAUD
        self._boot_end = 0.0
        self._play_since: float | None = None
        self._pin = BaudPin(-BaudPin.AFTER_POWER_ON)

    def switch_on(self, time: float, boot_seconds: float, play: bool) -> None:
        """Switch on and start the boot loader; `play`: the Play button is held."""
        self.on = True
        self._boot_end = time + boot_seconds
        self._play_since = time if play else None
        self._pin = BaudPin(time)

    def booting(self, time: float) -> bool:
        """Return whether the boot loader still runs."""
        return time < self._boot_end - TOLERANCE

    def play_held(self, play: bool, time: float) -> bool:
        """Look at the Play button; True once, after it was held for 4 s from power-on."""
        if not play:
            self._play_since = None
        if self._play_since is None or time < self._play_since + PLAY_HELD - TOLERANCE:
            return False
        self._play_since = None
        return True

    def pin_pulsed(self, high: bool, time: float) -> bool:
        """
        Look at the baud rate change pin; True when it has asked for 19200.

        The rate at power-on changes too: 19200 stays through the power button, until the battery
        fails or the Baud command sets another rate (manual: Method 2).
        """
        if not self._pin.see(high, time):
            return False
        self.default_baud = SLOW_BAUD
        return True
