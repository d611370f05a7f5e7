# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The iRobot Create Open Interface (2006), as data and pure functions.

No ROS, no serial port, no clock: bytes and values in, values and bytes out. Every command is a
class in `commands`, every packet a field of `readings.Readings`; `stream` finds frames and
commands in a stream of bytes.
Quantities are in the manual's units (mm, mm/s, degrees, mV, mA, mAh).
"""

from ..robot import SLOT
from .codes import (
    BaudCode,
    BumpsAndWheelDrops,
    Buttons,
    ChargingSources,
    ChargingState,
    DemoNumber,
    DigitalInputs,
    DriverBits,
    Event,
    Infrared,
    LedBits,
    Mode,
    OutputBits,
    Overcurrents,
    Radius,
    StreamState,
)
from .commands import (
    ACTUATE,
    Baud,
    COMMANDS,
    Control,
    Cover,
    CoverAndDock,
    Demo,
    DigitalOutputs,
    Drive,
    DriveDirect,
    Full,
    Leds,
    LowSideDrivers,
    Note,
    NOTES_PER_SECOND,
    PauseResumeStream,
    PlayScript,
    PlaySong,
    PwmLowSideDrivers,
    QueryList,
    REST,
    Safe,
    Script,
    SendIr,
    Sensors,
    ShowScript,
    Song,
    SOUNDING,
    Spot,
    Start,
    Stream,
    WaitAngle,
    WaitDistance,
    WaitEvent,
    WaitTime,
)
from .declaration import Command
from .packets import BITS_PER_BYTE, Budget, FRAME_LIMIT, GROUPS, HEADER, PacketList, size_of
from .readings import NAMES, NUMBERS, Packet, PACKETS, Readings
from .stream import Checksum, CommandReader, Frame, Garbage, StreamReader, UnknownOpcode
