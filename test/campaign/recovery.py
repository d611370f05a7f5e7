# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Steps that many faults share: drive, then wait until everything is as it was."""

from random import Random
import time

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import PlaySong, SetMode

from campaign.fault import Result
from campaign.stage import SONG, Stage

SERVICE_TIMEOUT = 0.5
"""Seconds within which a service must answer when there is no robot."""
STEADY = 0.1
"""Seconds for which all must be as it was: a robot that was in Safe mode when its line came back
reports that until it gets the driver's Start, and is in Safe mode again a moment later."""


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
    if not song.success or stage.control.truth()['song_number'] != SONG:
        result.trouble = f'the song is lost: {song.message}'
    stage.wait(0.2)
    return result
