# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Makes the robot do moves, one at a time, and watches that nothing disturbs them."""

from enum import Enum

from ...driver import Driver, MotionLimits
from ...driver.goals.goal import bumps
from ...robot import MM_PER_M
from .moves import Move, Reads
from .notebook import Notebook, PENDING

LIMITS = MotionLimits(linear_acceleration=0.0, angular_acceleration=0.0)
"""None on accelerations: steps show most of a robot."""
REPEAT = 0.1
"""Seconds from one command to the next of the same speeds."""
TELLING = 0.8
"""Seconds after a request in which readings are frequent."""
MOST_LOOKS = 30
"""Readings before a move after which it begins though they are not zero."""


class Stage(Enum):
    """How far a move has come."""

    IDLE = 'idle'
    EMPTYING = 'emptying'
    """The counts are read once, so that they are empty."""
    MOVING = 'moving'
    RESTING = 'resting'
    ENDING = 'ending'
    """The last reading is awaited."""


class Runner:
    """One robot that moves as told. Pure, as the driver is: `poll` has the time."""

    def __init__(self, driver: Driver, notebook: Notebook) -> None:
        self._driver, self._notebook = driver, notebook
        driver.set_limits(LIMITS)
        self.stage = Stage.IDLE
        self.disturbance: str | None = None
        """Why the last move ended early; None where it did not."""
        self._move = Move((), Reads.END)
        self._first = self._looked = 0
        self._segment = self._looks = 0
        self._began = self._asked_at = self._changed_at = 0.0
        self._told = (-1.0, 0, 0)
        self._polled_frames, self._polled_at = 0, 0.0

    @property
    def busy(self) -> bool:
        """Whether a move is under way."""
        return self.stage is not Stage.IDLE

    def begin(self, move: Move) -> None:
        """Start a move."""
        self._move, self.disturbance, self._looks = move, None, 0
        self._ask()
        self.stage = Stage.EMPTYING

    def poll(self, now: float) -> None:
        """Go on with the move."""
        heard = len(self._notebook.frames)
        if not self.busy or heard == self._polled_frames and now - self._polled_at < REPEAT:
            return
        self._polled_frames, self._polled_at = heard, now
        self._watch(now)
        if not self.busy:
            return
        seconds = self._notebook.seconds - self._began
        match self.stage:
            case Stage.EMPTYING:
                if self._answered() and self._at_rest():
                    self._began = self._notebook.seconds
                    self._turn_page(0)
                    self.stage = Stage.MOVING
            case Stage.MOVING:
                self._follow(seconds, now)
            case Stage.RESTING:
                self._drive(0, 0, now)
                if seconds > self._move.seconds:
                    self._ask()
                    self.stage = Stage.ENDING
                elif self._settled:
                    self._notebook.ask_no_more()
            case Stage.ENDING:
                if self._answered():
                    self.stage = Stage.IDLE

    def stop(self, now: float) -> None:
        """End the move, and stop the wheels."""
        self._notebook.ask_no_more()
        self._driver.stop(now)
        self.stage = Stage.IDLE

    def _follow(self, seconds: float, now: float) -> None:
        """Drive as the segment says that it is time for."""
        for number, segment in enumerate(self._move.segments):
            if seconds < segment.seconds:
                if number != self._segment:
                    self._turn_page(number)
                elif self._settled:
                    self._notebook.ask_no_more()
                self._drive(segment.right, segment.left, now)
                return
            seconds -= segment.seconds
        self._turn_page(len(self._move.segments))
        self._drive(0, 0, now)
        self.stage = Stage.RESTING

    def _turn_page(self, segment: int) -> None:
        """Begin a segment: its first moments tell most."""
        self._segment = segment
        self._changed_at = self._notebook.seconds - self._began
        if self._move.intervals:
            self._notebook.ask(self._move.intervals)

    @property
    def _settled(self) -> bool:
        """Whether the wheels have followed, and frequent readings no longer tell."""
        passed = self._notebook.seconds - self._began - self._changed_at
        return self._move.reads is Reads.OFTEN and passed > TELLING

    def _drive(self, right: int, left: int, now: float) -> None:
        at, *told = self._told
        if told == [right, left] and now - at < REPEAT:
            return
        self._told = now, right, left
        self._driver.drive((right + left) / 2 / MM_PER_M,
                           (right - left) / MM_PER_M / LIMITS.wheel_separation, now)

    def _ask(self) -> None:
        self._notebook.ask()
        self._asked_at, self._looked = self._notebook.seconds, len(self._notebook.frames)

    def _answered(self) -> bool:
        """Tell whether a reading came since it was asked for; ask again where none comes."""
        frames = self._notebook.frames
        for index in range(self._looked, len(frames)):
            if frames[index].distance is not None:
                if self.stage is Stage.EMPTYING:
                    self._first = index
                self._looked = len(frames)
                return True
        self._looked = len(frames)
        if self._notebook.seconds - self._asked_at > PENDING * frames[-1].dt:
            self._ask()
        return False

    def _at_rest(self) -> bool:
        """Tell whether the counts are empty now; look again where wheels may still turn."""
        frame = self._notebook.frames[self._first]
        self._looks += 1
        if (frame.distance, frame.angle) == (0, 0) or self._looks == MOST_LOOKS:
            return True
        self._ask()
        return False

    def _watch(self, now: float) -> None:
        """End a move that something disturbs."""
        health = self._driver.health(now)
        readings = health.readings
        if not health.answered:
            self.disturbance = 'the robot does not answer any more'
        elif health.hazards:
            self.disturbance = ', '.join(cause.value for cause in health.hazards)
        elif not health.mode.can_drive:
            self.disturbance = f'the robot left Safe mode: {health.mode.reason or "no reason"}'
        elif readings.has('oi_mode') and bumps(readings):
            self.disturbance = 'the bumper was pressed'
        else:
            return
        self.stop(now)
