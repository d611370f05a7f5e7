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

DEFAULT_BAUD = START_BAUDS[0]
"""Bits per second at power-on (manual: Serial Port Settings; the Play button and the baud rate
pin, its two ways to 19200, are not simulated)."""
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

    def __init__(self, *, overrun: bool, buffer: int) -> None:
        self.host_baud: int | None = None
        """Baud rate of the host; None: always the right one."""
        self._out = bytearray()
        self._last_onset = -1.0
        self._overrun = overrun
        self._buffer = buffer
        self.reset(0.0)

    def reset(self, time: float) -> None:
        """Start again at power-on."""
        self.baud = DEFAULT_BAUD
        self._wire_free = self._paused_until = time

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


BANNER = (
    b'bl-start\r\n1.2.3\r\nbl-end\r\n'
    b'2006-09-12-1137-L   \r\n'
    b'RDK by iRobot!\r\nMC9S12E128\r\n'
    b'2006-09-12-1137-L\r\n'
    b'battery-current-zero 258\r\n'
    b'assembly 0x02\r\n')
"""Text sent at power-on (reported: about 140 bytes like these; the words are a guess)."""
