# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the host can set: wheels, LEDs, low side drivers, outputs, infrared; and the speaker."""

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

from ... import oi
from ...oi import DriverBits, LedBits, Note, NOTES_PER_SECOND, OutputBits, REST, SOUNDING
from ...oi.commands import DUTY, wheel_speeds, WheelSpeeds
from ...oi.script import STANDING
from ...robot import BODY_RADIUS, MM_PER_M
from .. import TOLERANCE
from ..body import Body


class Lights(NamedTuple):
    """The LEDs: Play and Advance; Power with its color (0 green, 255 red) and intensity."""

    bits: LedBits = LedBits(0)
    color: int = 0
    intensity: int = 0


DARK = Lights()


class ActuatorState:
    """What the host set last; wheels and low side drivers are passed on to the body."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self._separation = body.config.encoder_separation * MM_PER_M
        self.infrared_sent: deque[int] = deque(maxlen=64)
        """The characters sent by Send IR, the newest last."""
        self.reset()

    def reset(self) -> None:
        self.velocity = self.radius = self.right = self.left = 0
        self.outputs = OutputBits(0)
        self.lights = DARK
        self.turn_wheels(STANDING)
        self.switch_drivers(0, 0, 0)

    def execute(self, command: oi.Command) -> None:
        """
        Carry out a command if it is for the actuators; its values are in range.

        Drive changes packets 39 and 40, Drive Direct 41 and 42; the others stay.
        """
        match command:
            case oi.Drive(velocity=velocity, radius=radius):
                self.velocity, self.radius = velocity, radius
                self.turn_wheels(wheel_speeds(velocity, radius, self._separation))
            case oi.DriveDirect(right=right, left=left):
                self.right, self.left = right, left
                self.turn_wheels(WheelSpeeds(right, left))
            case oi.Leds(bits=bits, color=color, intensity=intensity):
                self.lights = Lights(LedBits(bits), color, intensity)
            case oi.DigitalOutputs(bits=bits):
                self.outputs = OutputBits(bits)
            case oi.LowSideDrivers(bits=bits):
                self.switch_drivers(*(DUTY.high if bits & bit else 0 for bit in DriverBits))
            case oi.PwmLowSideDrivers(driver_0=driver_0, driver_1=driver_1, driver_2=driver_2):
                self.switch_drivers(driver_0, driver_1, driver_2)
            case oi.SendIr(byte=byte):
                self.infrared_sent.append(byte)

    def turn_wheels(self, wheels: WheelSpeeds) -> None:
        """Set the wheel speeds; packets 39 to 42 stay."""
        self.wheels = wheels
        self._body.drive(right=wheels.right / MM_PER_M, left=wheels.left / MM_PER_M)

    def switch_drivers(self, driver_0: int, driver_1: int, driver_2: int) -> None:
        """Set the duty cycles of the low side drivers, in 128ths."""
        self.duties = (driver_0, driver_1, driver_2)
        full = DUTY.high
        self._body.low_side(
            duty0=driver_0 / full, duty1=driver_1 / full, duty2=driver_2 / full)

    def moves_into_cliff(self) -> bool:
        """Return whether a cliff stops Safe mode: moving forward or on a small radius (manual)."""
        right, left = self.wheels
        forward, turn = (right + left) / 2, abs(right - left)
        return forward > 0 or abs(forward) * self._separation < BODY_RADIUS * MM_PER_M * turn

    @property
    def requested(self) -> dict[str, int]:
        """Packets 39 to 42."""
        return {
            'requested_velocity': self.velocity, 'requested_radius': self.radius,
            'requested_right_velocity': self.right, 'requested_left_velocity': self.left,
        }


BEEP = (Note(84, 10),)
"""Sound of Start if the interface was off (manual: Start, 'beeps once'; the pitch is a guess)."""


class Speaker:
    """Plays one song or beep at a time. Times are seconds on the robot's clock."""

    def __init__(self) -> None:
        self.songs: dict[int, tuple[Note, ...]] = {}
        self.number = 0
        """Packet 36: the song played last."""
        self._notes: Sequence[Note] = ()
        self._begun = self._end = 0.0
        self._is_song = False

    def execute(self, command: oi.Command, time: float) -> None:
        """Carry out a command if it is for the speaker; its values are in range."""
        match command:
            case oi.Song(number=number, notes=notes):
                self.songs[number] = notes
            case oi.PlaySong(number=number) if (
                    number in self.songs and not self.song_playing(time)):
                self.number = number
                self._begin(self.songs[number], time, is_song=True)

    def beep(self, time: float) -> None:
        """Beep as the robot itself does; a song that plays is not interrupted."""
        if not self.song_playing(time):
            self._begin(BEEP, time, is_song=False)

    def _begin(self, notes: Sequence[Note], time: float, *, is_song: bool) -> None:
        self._notes, self._is_song = notes, is_song
        self._begun = time
        self._end = time + sum(note.duration for note in notes) / NOTES_PER_SECOND

    def song_playing(self, time: float) -> bool:
        """Return whether a song plays (packet 37)."""
        return self._is_song and time < self._end - TOLERANCE

    def note(self, time: float) -> int:
        """Return the MIDI number of the note that sounds now; REST for silence."""
        if time >= self._end - TOLERANCE:
            return REST
        end = self._begun
        for note in self._notes:
            end += note.duration / NOTES_PER_SECOND
            if time < end - TOLERANCE:
                return note.number if note.number in SOUNDING else REST
        return REST
