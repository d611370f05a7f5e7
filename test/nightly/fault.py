# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A fault: how to make it, what is promised, the result of a try; and steps that many share."""

from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
import time

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import PlaySong, SetMode

from nightly.stage import QUICK, SONG, Stage

SERVICE_TIMEOUT = 0.5
"""Seconds within which a service must answer when there is no robot."""
STEADY = 0.1
"""Seconds for which all must be as it was: a robot that was in Safe mode when its line came back
reports that until it gets the driver's Start, and is in Safe mode again a moment later."""


@dataclass
class Result:
    """The result of one try."""

    recovery: float | None = None
    """Seconds from the end of the fault until everything is restored and published again."""
    zero: float | None = None
    """Seconds until the wheels had zero speed requested."""
    wrong: list[str] = field(default_factory=list)
    """Messages with wrong values that were published."""
    trouble: str = ''
    """Why the try failed; empty if it did not."""


Try = Callable[[Stage, Random], Result]
"""A function that makes a fault once and returns what happened."""


@dataclass(frozen=True)
class Fault:
    """One kind of fault, and the limits that are promised for it."""

    name: str
    try_once: Try
    keeps_node: bool = True
    """Whether the same node and robot serve the next try."""
    recovery: float | None = 1.0
    """Limit of `Result.recovery`; None if nothing has to recover."""
    zero: float | None = 1.0
    """Limit of `Result.zero`; None if the wheels do not turn."""
    node: dict[str, object] = field(default_factory=dict)
    """Parameters of the node."""
    robot: tuple[str, ...] = QUICK
    """Options of the simulated robot."""

    def prepare(self, stage: Stage) -> None:
        """Start the robot and the node if the stage has none; end a node that is not wanted."""
        if stage.robot is None:
            stage.start_robot(*self.robot)
        serves = stage.node is not None and stage.node.running()
        if self.keeps_node and not serves:
            stage.start_node(**self.node)
            stage.set_outputs()
        elif serves and not self.keeps_node:
            stage.end_node()

    def attempt(self, stage: Stage, random: Random) -> Result:
        """Make the fault once; an error or a timeout is a result as well."""
        wrong = len(stage.watch.wrong)
        try:
            self.prepare(stage)
            result = self.try_once(stage, random)
        except (AssertionError, TimeoutError, OSError) as error:
            result = Result(trouble=str(error) or repr(error))
        result.wrong = stage.watch.wrong[wrong:]
        return result

    def failure(self, result: Result, slack: float) -> str:
        """Return why a try has failed; empty if it has not. `slack` is a factor for the limits."""
        limits = ((self.recovery, result.recovery, 'recovery'),
                  (self.zero, result.zero, 'zero speed'))
        late = [f'{what} after {took:.3f} s, not {limit:g} s' for limit, took, what in limits
                if limit is not None and took is not None and took > limit * slack]
        return '; '.join(filter(None, (result.trouble, *late, *result.wrong[:1])))


def start_driving(stage: Stage, random: Random) -> None:
    """Drive at a random velocity, then send no more commands."""
    stage.drive(random.uniform(0.1, 0.4), random.uniform(-1.0, 1.0))
    stage.wait(random.uniform(0.0, 0.2))


def until_link_down(stage: Stage) -> None:
    """Wait until the node says that the robot does not answer."""
    stage.until(lambda: stage.watch.mode == Mode.UNKNOWN, 'mode UNKNOWN')


def check_without_robot(stage: Stage, result: Result) -> None:
    """Check that services fail at once and no odometry is published while there is no robot."""
    parted, begun = time.time(), time.monotonic()
    reply = stage.ros.call(SetMode, 'set_mode', mode=Mode.SAFE)
    if reply.success or not reply.message or time.monotonic() - begun > SERVICE_TIMEOUT:
        result.trouble = f'set_mode without a robot: {reply}'
    stage.wait(0.1)
    if stage.watch.newest > parted:
        result.trouble = 'odom is published without a robot'


def recovered(stage: Stage, result: Result) -> Result:
    """Wait until the wheels have stopped and everything is restored; play the song."""
    begun, odoms = time.monotonic(), stage.watch.odoms
    back_at: float | None = None

    def back() -> bool:
        nonlocal back_at
        now = time.monotonic()
        if result.zero is None and stage.stopped():
            result.zero = now - begun
        if not (result.zero is not None and stage.watch.mode == Mode.SAFE
                and stage.watch.odoms > odoms and stage.restored()):
            back_at = None
            return False
        back_at = now if back_at is None else back_at
        return now - back_at >= STEADY
    stage.until(back, 'recovery')
    assert back_at is not None
    result.recovery = back_at - begun
    song = stage.ros.call(PlaySong, 'play_song', number=SONG)
    if not song.success:
        result.trouble = f'the song is lost: {song.message}'
    stage.until(lambda: stage.control.truth()['song_number'] == SONG, 'the song')
    stage.wait(0.2)
    return result
