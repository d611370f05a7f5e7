"""Power-on: the boot loader, the Play button held, and the baud rate that results."""

from __future__ import annotations

from .uart import BaudPin, DEFAULT_BAUD, SLOW_BAUD

BANNER = (
    b'bl-start\r\n1.2.3\r\nbl-end\r\n'
    b'2006-09-12-1137-L   \r\n'
    b'RDK by iRobot!\r\nMC9S12E128\r\n'
    b'2006-09-12-1137-L\r\n'
    b'battery-current-zero 258\r\n'
    b'assembly 0x02\r\n')
"""What is said at power-on (reported: about 140 bytes, in this vein; the words are a guess)."""
PLAY_HELD = 4.0
"""Seconds (manual: Serial Port Settings, Method 1)."""
EARLY = 1e-6


class Power:
    """Whether the processor runs, and at which rate its port begins.  Times in robot seconds."""

    __slots__ = ('on', 'default_baud', '_boot_end', '_play_since', '_pin')

    def __init__(self) -> None:
        """Be on, and booted long ago."""
        self.on = True
        self.default_baud = DEFAULT_BAUD
        self._boot_end = 0.0
        self._play_since: float | None = None
        self._pin = BaudPin(-BaudPin.AFTER_POWER_ON)

    def switch_on(self, time: float, boot_seconds: float, play: bool) -> None:
        """Begin to boot, with the Play button held or not."""
        self.on = True
        self._boot_end = time + boot_seconds
        self._play_since = time if play else None
        self._pin = BaudPin(time)

    def booting(self, time: float) -> bool:
        """Tell whether the boot loader still runs."""
        return time < self._boot_end - EARLY

    def play_held(self, play: bool, time: float) -> bool:
        """Look at the Play button; True once, when it was held from power-on for 4 s."""
        if not play:
            self._play_since = None
        if self._play_since is None or time < self._play_since + PLAY_HELD - EARLY:
            return False
        self._play_since = None
        return True

    def pin_pulsed(self, high: bool, time: float) -> bool:
        """
        Look at the baud rate change pin; True when it has asked for 19200.

        That lasts over the power button, until the battery fails or Baud says otherwise (Method
        2), so the rate at power-on changes too.
        """
        if not self._pin.see(high, time):
            return False
        self.default_baud = SLOW_BAUD
        return True
