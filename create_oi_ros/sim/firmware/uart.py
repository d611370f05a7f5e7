# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The robot's serial port: its baud rate, bytes at a wrong rate, and what fits on the wire.

The port delays nothing: bytes can be fetched as soon as they are sent, and the server delays them
as the wire would. The port does compute the time that the wire would need, so that a stream that
asks for too much is corrupted.
"""

from ...oi import BITS_PER_BYTE
from ...oi.codes import FAST_BAUD, FAST_SPACING, START_BAUDS
from ...robot import SLOT
from ..numbers import TOLERANCE

DEFAULT_BAUD, SLOW_BAUD = START_BAUDS
"""Bits per second at power-on, and after the two ways of the manual's Serial Port Settings."""
BAUD_PAUSE = 0.1
"""Seconds after Baud in which nothing is received or sent (manual: Baud)."""


def resampled(data: bytes, sent_at: int, read_at: int) -> bytes:
    """
    Return the bytes that a receiver at one rate reads from bytes sent at another (bits/s).

    The line is sampled as a UART does it: a falling edge, then eight bits, each in its middle.
    """
    if sent_at == read_at:
        return data
    levels: list[int] = []
    for byte in data:
        levels += [0, *(byte >> place & 1 for place in range(8)), 1]
    line, end = levels + [1] * (BITS_PER_BYTE * (1 + sent_at // read_at)), len(levels)
    ratio = sent_at / read_at
    received = bytearray()
    at = 0.0
    while at < end:
        if line[int(at)]:
            at = int(at) + 1
            continue
        received.append(sum(line[int(at + (place + 1.5) * ratio)] << place for place in range(8)))
        at += (BITS_PER_BYTE - 0.5) * ratio
        # A stop bit that is low is a framing error: a UART waits for the line to rise.
        while at < end and not line[int(at)]:
            at = int(at) + 1
    return bytes(received)


class Uart:
    """The robot's end of the serial line; times are seconds on the robot's clock."""

    __slots__ = ('baud', 'host_baud', '_out', '_wire_free', '_paused_until', '_last_onset',
                 '_overrun', '_buffer')

    def __init__(self, *, overrun: bool, buffer: int) -> None:
        self.baud = DEFAULT_BAUD
        self.host_baud: int | None = None
        """Baud rate of the host; None: always the right one."""
        self._out = bytearray()
        self._wire_free = 0.0
        self._paused_until = 0.0
        self._last_onset = -1.0
        self._overrun = overrun
        self._buffer = buffer

    def change(self, baud: int, time: float) -> None:
        """Carry out the Baud command."""
        self.baud = baud
        self._paused_until = time + BAUD_PAUSE

    def paused(self, time: float) -> bool:
        """Return whether the pause after a change of rate still lasts."""
        return time < self._paused_until

    def receive(self, data: bytes, time: float) -> bytes:
        """Return what the robot reads of bytes from the host; the last one arrives now."""
        if self.paused(time):
            return b''
        if self.host_baud not in (None, self.baud):
            data = resampled(data, self.host_baud or self.baud, self.baud)
        return self._without_overrun(data, time) if self._overrun else data

    def _without_overrun(self, data: bytes, time: float) -> bytes:
        if self.baud < FAST_BAUD:
            return data
        kept = bytearray()
        spacing = BITS_PER_BYTE / self.baud
        for place, byte in enumerate(data):
            onset = time + place * spacing
            if onset - self._last_onset >= FAST_SPACING:
                kept.append(byte)
                self._last_onset = onset
        return bytes(kept)

    def stream(self, frame: bytes, time: float) -> None:
        """Send a frame of the stream, as much of it as fits into the buffer."""
        waiting = max(0.0, self._wire_free - time)
        room = self._buffer - int(waiting * self.baud / BITS_PER_BYTE)
        self.reply(frame[:max(0, room)], time)

    def reply(self, data: bytes, time: float) -> None:
        """Send the reply to a command, whole."""
        if self.paused(time):
            return
        self._wire_free = max(time, self._wire_free) + len(data) * BITS_PER_BYTE / self.baud
        if self.host_baud not in (None, self.baud):
            data = resampled(data, self.baud, self.host_baud or self.baud)
        self._out += data

    def take(self) -> bytes:
        """Return the bytes sent since the last call."""
        data = bytes(self._out)
        self._out.clear()
        return data

    def reset(self, baud: int, time: float) -> None:
        """Start again at power-on."""
        self.baud = baud
        self._wire_free = self._paused_until = time


class BaudPin:
    """Watches the baud rate change pin for three low pulses (manual: Serial Port Settings)."""

    PULSES = 3
    SHORTEST, LONGEST = 0.05, 0.5
    """Limits of a pulse, seconds."""
    AFTER_POWER_ON = 2.0
    """Seconds in which pulses do not count."""
    GAP = 2.0
    """Seconds high after which the count starts again (guess)."""
    TOLERATED = SLOT - TOLERANCE
    """Error of a measured pulse, seconds: the pin is read once in a slot."""

    __slots__ = ('_count', '_high', '_since', '_ignored_until')

    def __init__(self, power_on: float) -> None:
        self._count = 0
        self._high = True
        self._since = power_on
        self._ignored_until = power_on + self.AFTER_POWER_ON

    def update(self, high: bool, time: float) -> bool:
        """Take the level of the pin; return True when the third pulse has just ended."""
        if high == self._high:
            return False
        lasted = time - self._since
        self._high, self._since = high, time
        if not high:
            if lasted > self.GAP:
                self._count = 0
            return False
        right = self.SHORTEST - self.TOLERATED <= lasted <= self.LONGEST + self.TOLERATED
        begun = time - lasted >= self._ignored_until
        self._count = self._count + 1 if right and begun else 0
        if self._count < self.PULSES:
            return False
        self._count = 0
        return True


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
        return time < self._boot_end - TOLERANCE

    def update_play(self, play: bool, time: float) -> bool:
        """Take the Play button; return True once, after it was held for 4 s from power-on."""
        if not play:
            self._play_since = None
        if self._play_since is None or time < self._play_since + PLAY_HELD - TOLERANCE:
            return False
        self._play_since = None
        return True

    def update_pin(self, high: bool, time: float) -> bool:
        """
        Take the level of the baud rate change pin; return True when it has asked for 19200.

        The rate at power-on changes too: 19200 stays through the power button, until the battery
        fails or the Baud command sets another rate (manual: Method 2).
        """
        if not self._pin.update(high, time):
            return False
        self.default_baud = SLOW_BAUD
        return True
