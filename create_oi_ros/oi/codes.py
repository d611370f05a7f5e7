# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The enumerations of the Open Interface: every code and bit that has a name in the manual."""

from enum import IntEnum, IntFlag


class Mode(IntEnum):
    """Open Interface modes (manual: OI Mode, packet 35; iRobot Create Open Interface Modes)."""

    __hash__ = int.__hash__  # Enum's is a Python function, and every frame looks a mode up

    OFF = 0
    PASSIVE = 1
    SAFE = 2
    FULL = 3


class BaudCode(IntEnum):
    """Baud codes (manual: Baud, opcode 129)."""

    B300 = 0
    B600 = 1
    B1200 = 2
    B2400 = 3
    B4800 = 4
    B9600 = 5
    B14400 = 6
    B19200 = 7
    B28800 = 8
    B38400 = 9
    B57600 = 10
    B115200 = 11

    @property
    def rate(self) -> int:
        """Bits per second."""
        return int(self.name[1:])


START_BAUDS = (BaudCode.B57600.rate, BaudCode.B19200.rate)
"""Rates that the robot can start with, the usual one first (manual: Serial Port Settings)."""
FAST_BAUD = BaudCode.B115200.rate
FAST_SPACING = 0.0002
"""Least seconds between the starts of two bytes to the robot at FAST_BAUD (manual: Baud)."""


class DemoNumber(IntEnum):
    """Built-in demos (manual: Demo, opcode 136)."""

    ABORT = -1
    COVER = 0
    COVER_AND_DOCK = 1
    SPOT_COVER = 2
    MOUSE = 3
    DRIVE_FIGURE_EIGHT = 4
    WIMP = 5
    HOME = 6
    TAG = 7
    PACHELBEL = 8
    BANJO = 9


class Radius(IntEnum):
    """
    Special radii of Drive, in mm (manual: Drive, opcode 137, Special cases).

    The manual gives two codes for driving straight, hex 8000 and 7FFF.
    """

    STRAIGHT = -32768
    STRAIGHT_7FFF = 32767
    IN_PLACE_CLOCKWISE = -1
    IN_PLACE_COUNTER_CLOCKWISE = 1


class StreamState(IntEnum):
    """Argument of Pause/Resume Stream (manual: opcode 150)."""

    PAUSE = 0
    RESUME = 1


class Event(IntEnum):
    """Events for Wait Event; the negative of an event is its inverse (manual: opcode 158)."""

    WHEEL_DROP = 1
    FRONT_WHEEL_DROP = 2
    LEFT_WHEEL_DROP = 3
    RIGHT_WHEEL_DROP = 4
    BUMP = 5
    LEFT_BUMP = 6
    RIGHT_BUMP = 7
    VIRTUAL_WALL = 8
    WALL = 9
    CLIFF = 10
    LEFT_CLIFF = 11
    FRONT_LEFT_CLIFF = 12
    FRONT_RIGHT_CLIFF = 13
    RIGHT_CLIFF = 14
    HOME_BASE = 15
    ADVANCE_BUTTON = 16
    PLAY_BUTTON = 17
    DIGITAL_INPUT_0 = 18
    DIGITAL_INPUT_1 = 19
    DIGITAL_INPUT_2 = 20
    DIGITAL_INPUT_3 = 21
    OI_MODE_PASSIVE = 22


class ChargingState(IntEnum):
    """Charging states (manual: packet 21)."""

    NOT_CHARGING = 0
    RECONDITIONING = 1
    FULL_CHARGING = 2
    TRICKLE = 3
    WAITING = 4
    FAULT = 5


class Infrared(IntEnum):
    """Characters of the infrared receiver that have a name (manual: packet 17)."""

    REMOTE_LEFT = 129
    REMOTE_FORWARD = 130
    REMOTE_RIGHT = 131
    REMOTE_SPOT = 132
    REMOTE_MAX = 133
    REMOTE_SMALL = 134
    REMOTE_MEDIUM = 135
    REMOTE_LARGE_CLEAN = 136
    REMOTE_PAUSE = 137
    REMOTE_POWER = 138
    REMOTE_ARC_FORWARD_LEFT = 139
    REMOTE_ARC_FORWARD_RIGHT = 140
    REMOTE_DRIVE_STOP = 141
    SCHEDULING_SEND_ALL = 142
    SCHEDULING_SEEK_DOCK = 143
    HOME_BASE_RESERVED = 240
    HOME_BASE_FORCE_FIELD = 242
    HOME_BASE_GREEN_BUOY = 244
    HOME_BASE_GREEN_BUOY_AND_FORCE_FIELD = 246
    HOME_BASE_RED_BUOY = 248
    HOME_BASE_RED_BUOY_AND_FORCE_FIELD = 250
    HOME_BASE_RED_BUOY_AND_GREEN_BUOY = 252
    HOME_BASE_RED_BUOY_GREEN_BUOY_AND_FORCE_FIELD = 254
    NONE = 255


BEAMS = int(Infrared.HOME_BASE_RESERVED)
"""A character of a Home Base is this number plus a bit for each beam that is received."""
RED_BUOY = Infrared.HOME_BASE_RED_BUOY - BEAMS
GREEN_BUOY = Infrared.HOME_BASE_GREEN_BUOY - BEAMS
FORCE_FIELD = Infrared.HOME_BASE_FORCE_FIELD - BEAMS


class LedBits(IntFlag):
    """Bits of the first byte of LEDs (manual: opcode 139)."""

    PLAY = 1 << 1
    ADVANCE = 1 << 3


class DriverBits(IntFlag):
    """Bits of Low Side Drivers (manual: opcode 138; connector pins 22, 23 and 24)."""

    DRIVER_0 = 1 << 0
    DRIVER_1 = 1 << 1
    DRIVER_2 = 1 << 2


class OutputBits(IntFlag):
    """Bits of Digital Outputs (manual: opcode 147; connector pins 19, 7 and 20)."""

    OUTPUT_0 = 1 << 0
    OUTPUT_1 = 1 << 1
    OUTPUT_2 = 1 << 2


class BumpsAndWheelDrops(IntFlag):
    """Bits of packet 7."""

    BUMP_RIGHT = 1 << 0
    BUMP_LEFT = 1 << 1
    WHEEL_DROP_RIGHT = 1 << 2
    WHEEL_DROP_LEFT = 1 << 3
    WHEEL_DROP_CASTER = 1 << 4


class Overcurrents(IntFlag):
    """Bits of packet 14. Driver 1 comes before driver 0 in both of the manual's tables."""

    DRIVER_1 = 1 << 0
    DRIVER_0 = 1 << 1
    DRIVER_2 = 1 << 2
    RIGHT_WHEEL = 1 << 3
    LEFT_WHEEL = 1 << 4


class Buttons(IntFlag):
    """Bits of packet 18."""

    PLAY = 1 << 0
    ADVANCE = 1 << 2


class DigitalInputs(IntFlag):
    """Bits of packet 32; the baud rate change pin is high unless it is pulled low."""

    INPUT_0 = 1 << 0
    INPUT_1 = 1 << 1
    INPUT_2 = 1 << 2
    INPUT_3 = 1 << 3
    BAUD_RATE_CHANGE = 1 << 4


class ChargingSources(IntFlag):
    """Bits of packet 34: power sources that are present."""

    INTERNAL_CHARGER = 1 << 0
    HOME_BASE = 1 << 1
