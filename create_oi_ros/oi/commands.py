# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Every command of the Open Interface, declared once.

The class line states the opcode, the modes in which the robot obeys the command and the mode
that it enters. The fields state format, range and unit, in the order of the wire. The docstring
says what the command does (manual: Open Interface Command Reference).
"""

from collections.abc import Iterable
from typing import Annotated, NamedTuple

from .codes import (
    BaudCode,
    DemoNumber,
    DriverBits,
    Event,
    LedBits,
    Mode,
    OutputBits,
    Radius,
    StreamState,
)
from .declaration import Command
from .packets import PACKET_ID, PACKET_IDS
from .readings import number_of, numbers_of, SPEED
from .wire import bits, choice, Counted, signed_choice, Wire

STARTED = frozenset({Mode.PASSIVE, Mode.SAFE, Mode.FULL})
"""Modes for commands that need only a started Open Interface."""
ANY = STARTED | {Mode.OFF}
ACTUATE = frozenset({Mode.SAFE, Mode.FULL})
"""Modes for commands that use an actuator: wheels, LEDs, speaker, outputs."""

# Sections of the manual.
START = 'Getting Started Commands'
MODES = 'Mode Commands'
DEMOS = 'Demo Commands'
ACTUATORS = 'Actuator Commands'
INPUTS = 'Input Commands'
SCRIPTS = 'Script Commands'
WAITS = 'Wait Commands'

BYTE = Wire('B', 0, 255)
SIGNED_WORD = (-32768, 32767)
DUTY = Wire('B', 0, 128, '1/128')
NOTE_TIME = Wire('B', 0, 255, '1/64 s')
SONG_NUMBER = Wire('B', 0, 15)
SOUNDING = range(31, 128)
"""Note numbers that make a sound; all others are rests (manual: Song)."""
REST = 0
"""The note number used for a rest; the robot treats all numbers outside of SOUNDING alike."""
NOTES_PER_SECOND = 64
"""Note durations are in 64ths of a second (manual: Song)."""


class Start(Command, opcode=128, section=START, modes=ANY, enters=Mode.PASSIVE):
    """Start the Open Interface; the robot beeps if it was off. Send this before anything else."""


class Baud(Command, opcode=129, section=START, modes=STARTED):
    """
    Change the baud rate until power is cycled; wait 100 ms before sending at the new rate.

    At 115200 leave 200 microseconds between the onsets of two bytes, or some are lost.
    """

    code: Annotated[int, choice('B', BaudCode)]


class Control(Command, opcode=130, section=MODES, modes=STARTED, enters=Mode.SAFE):
    """Enter Safe mode; an old form of Safe, kept for the Roomba Open Interface."""


class Safe(Command, opcode=131, section=MODES, modes=STARTED, enters=Mode.SAFE):
    """Enter Safe mode: control with safety stops. Turns all LEDs off and ends charging."""


class Full(Command, opcode=132, section=MODES, modes=STARTED, enters=Mode.FULL):
    """Enter Full mode: control without safety stops. Ends charging."""


class Spot(Command, opcode=134, section=DEMOS, modes=STARTED, enters=Mode.PASSIVE):
    """Start the Spot Cover demo."""


class Cover(Command, opcode=135, section=DEMOS, modes=STARTED, enters=Mode.PASSIVE):
    """Start the Cover demo."""


class Demo(Command, opcode=136, section=DEMOS, modes=STARTED, enters=Mode.PASSIVE):
    """Start a built-in demo, or abort the running one."""

    demo: Annotated[int, choice('b', DemoNumber)]


RADIUS = Wire('h', -2000, 2000, 'mm', names=Radius)


class Drive(Command, opcode=137, section=ACTUATORS, modes=ACTUATE):
    """
    Drive along an arc; positive velocity is forward, positive radius turns left.

    The radius for straight may be written as -32768 or, as in the manual, hex 8000.
    """

    velocity: Annotated[int, SPEED]
    radius: Annotated[int, RADIUS]

    def __post_init__(self) -> None:
        if isinstance(self.radius, int):
            object.__setattr__(self, 'radius', RADIUS.signed(self.radius))


class LowSideDrivers(Command, opcode=138, section=ACTUATORS, modes=ACTUATE):
    """Switch the low side drivers on, at 100 % duty cycle, or off."""

    bits: Annotated[int, bits('B', DriverBits)]


class Leds(Command, title='LEDs', opcode=139, section=ACTUATORS, modes=ACTUATE):
    """Switch the Play and Advance LEDs; set colour (0 green, 255 red) and intensity of Power."""

    bits: Annotated[int, bits('B', LedBits)]
    color: Annotated[int, BYTE]
    intensity: Annotated[int, BYTE]


class Note(NamedTuple):
    """One note of a song: a MIDI note number and a duration in 64ths of a second."""

    number: int
    duration: int


class Song(Command, opcode=140, section=ACTUATORS, modes=STARTED):
    """Store a song. Note numbers outside 31 to 127 are rests."""

    number: Annotated[int, SONG_NUMBER]
    notes: Annotated[
        tuple[Note, ...], Counted(1, 16, (BYTE, NOTE_TIME), 'notes')]


class PlaySong(Command, opcode=141, section=ACTUATORS, modes=ACTUATE):
    """Play a stored song; ignored while a song is playing."""

    number: Annotated[int, SONG_NUMBER]


class Sensors(Command, opcode=142, section=INPUTS, modes=STARTED):
    """Request one packet or group, once; the reply has no id and no checksum."""

    packet: Annotated[int, PACKET_ID]

    def __init__(self, *, packet: int | str) -> None:
        object.__setattr__(self, 'packet', number_of(packet))


class CoverAndDock(
    Command, title='Cover and Dock', opcode=143, section=DEMOS, modes=STARTED, enters=Mode.PASSIVE,
):
    """Start the Cover and Dock demo."""


class PwmLowSideDrivers(
    Command, title='PWM Low Side Drivers', opcode=144, section=ACTUATORS, modes=ACTUATE,
):
    """Set the duty cycles of the low side drivers, in 128ths; driver 2 comes first."""

    driver_2: Annotated[int, DUTY]
    driver_1: Annotated[int, DUTY]
    driver_0: Annotated[int, DUTY]


class DriveDirect(Command, opcode=145, section=ACTUATORS, modes=ACTUATE):
    """Set the wheel speeds; the right wheel comes first."""

    right: Annotated[int, SPEED]
    left: Annotated[int, SPEED]


class DigitalOutputs(Command, opcode=147, section=ACTUATORS, modes=ACTUATE):
    """Set the three digital outputs of the cargo bay."""

    bits: Annotated[int, bits('B', OutputBits)]


class Stream(Command, opcode=148, section=INPUTS, modes=STARTED):
    """Request a list of packets every 15 ms, in frames with header, ids and checksum."""

    packets: Annotated[tuple[int, ...], Counted(0, len(PACKET_IDS), (PACKET_ID,), 'packets')]

    def __init__(self, *, packets: Iterable[int | str]) -> None:
        object.__setattr__(self, 'packets', numbers_of(packets))


class QueryList(Command, opcode=149, section=INPUTS, modes=STARTED):
    """Request a list of packets, once; the reply has no ids and no checksum."""

    packets: Annotated[tuple[int, ...], Counted(0, 255, (PACKET_ID,), 'packets')]

    def __init__(self, *, packets: Iterable[int | str]) -> None:
        object.__setattr__(self, 'packets', numbers_of(packets))


class PauseResumeStream(
    Command, title='Pause/Resume Stream', opcode=150, section=INPUTS, modes=STARTED,
):
    """Pause the stream, or resume it with the list that was requested last."""

    state: Annotated[int, choice('B', StreamState)]


class SendIr(Command, title='Send IR', opcode=151, section=ACTUATORS, modes=ACTUATE):
    """Send an infrared character through low side driver 1."""

    byte: Annotated[int, BYTE]


class Script(Command, opcode=152, section=SCRIPTS, modes=STARTED):
    """Store a script: the bytes of other commands. An empty script clears the stored one."""

    script: Annotated[bytes, Counted(0, 100, (BYTE,), 'bytes')]


class PlayScript(Command, opcode=153, section=SCRIPTS, modes=STARTED):
    """Play the stored script; as the last command of a script, repeat it without end."""


class ShowScript(Command, opcode=154, section=SCRIPTS, modes=STARTED):
    """Request the stored script: its length in bytes, then the bytes. Pauses the stream."""


class WaitTime(Command, opcode=155, section=WAITS, modes=STARTED):
    """Wait for a time; the robot ignores all input until then. Resolution 15 ms."""

    time: Annotated[int, Wire('B', 0, 255, '1/10 s')]


class WaitDistance(Command, opcode=156, section=WAITS, modes=STARTED):
    """Wait until the robot has travelled a distance; resets packet 19."""

    distance: Annotated[int, Wire('h', *SIGNED_WORD, 'mm')]


class WaitAngle(Command, opcode=157, section=WAITS, modes=STARTED):
    """Wait until the robot has turned by an angle; resets packet 20."""

    angle: Annotated[int, Wire('h', *SIGNED_WORD, 'deg')]


class WaitEvent(Command, opcode=158, section=WAITS, modes=STARTED):
    """Wait for an event; the negative of an event waits for its inverse."""

    event: Annotated[int, signed_choice('b', Event)]


COMMANDS: tuple[type[Command], ...] = tuple(
    Command.by_opcode[opcode] for opcode in sorted(Command.by_opcode))
"""All commands, in the order of their opcodes."""

STRAIGHT = (Radius.STRAIGHT, Radius.STRAIGHT_7FFF, 0)
"""Radii that mean straight. The manual allows 0 but does not explain it; straight is a guess."""


class WheelSpeeds(NamedTuple):
    """Speeds of the two wheels, mm/s; forward is positive."""

    right: float
    left: float


def wheel_speeds(velocity: float, radius: int, separation: float) -> WheelSpeeds:
    """
    Return the wheel speeds that Drive requests: velocity in mm/s, radius and separation in mm.

    The outer wheel may exceed the robot's top speed.
    """
    if radius in STRAIGHT:
        return WheelSpeeds(velocity, velocity)
    if radius == Radius.IN_PLACE_CLOCKWISE:
        return WheelSpeeds(-velocity, velocity)
    if radius == Radius.IN_PLACE_COUNTER_CLOCKWISE:
        return WheelSpeeds(velocity, -velocity)
    difference = velocity * separation / 2 / radius
    return WheelSpeeds(velocity + difference, velocity - difference)
