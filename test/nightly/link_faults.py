# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the link: lost and found, damaged bytes, and a robot that is in an odd state."""

from collections.abc import Callable
import os
from random import Random
import signal
import time

from create_oi_msgs.msg import Mode
from geometry_msgs.msg import Twist, Vector3

from create_oi_ros import oi
from nightly.fault import (
    check_without_robot,
    recovered,
    Result,
    start_driving,
    Try,
    until_link_down,
)
from nightly.stage import ANSWERS, OPENED, Stage

ADVICE = ('switch it off and on', 'another baud rate', 'no answer at')
"""Words in the node's log that tell the user what to do with a robot that does not follow."""
FOLLOW_TIMEOUT = 6.0
"""Seconds within which a robot must follow commands again, unless it waits."""
ADVICE_TIMEOUT = 3.0
"""Seconds within which the user must be told that the robot waits."""


def losing(lose: Callable[[Stage], None], find: Callable[[Stage], None]) -> Try:
    """Return a try in which the link is lost while the wheels turn, and found again."""
    def attempt(stage: Stage, random: Random) -> Result:
        start_driving(stage, random)
        lose(stage)
        until_link_down(stage)
        result = Result()
        check_without_robot(stage, result)
        stage.wait(random.uniform(0.0, 1.0))
        find(stage)
        return recovered(stage, result)
    return attempt


def sending(*lines: str) -> Callable[[Stage], None]:
    """Return a function that sends lines to the simulator's control socket."""
    return lambda stage: stage.control.tell(*lines)


unplug, plug = sending('cable unplug'), sending('cable plug')


def plug_elsewhere(stage: Stage) -> None:
    """Plug in while another program has the terminal's old number, so that it gets a new one."""
    taken = os.openpty()
    try:
        plug(stage)
    finally:
        for descriptor in taken:
            os.close(descriptor)


def restarted(stage: Stage, random: Random) -> Result:
    """Kill the simulator and start another one."""
    start_driving(stage, random)
    stage.end_robot()
    until_link_down(stage)
    stage.start_robot()
    return recovered(stage, Result())


def disturbing(fault: str) -> Try:
    """Return a try in which the simulator makes a line fault for a while as the wheels turn."""
    def attempt(stage: Stage, random: Random) -> Result:
        start_driving(stage, random)
        stage.control.tell(f'fault {fault}')
        stage.wait(random.uniform(0.5, 2.0))
        stage.control.tell('fault off')
        return recovered(stage, Result())
    return attempt


def damaging_commands(*faults: str) -> Try:
    """
    Return a try in which bytes to the robot are damaged, so that it may receive any command.

    The robot has recovered when the wheels have stopped and a fresh command brings Safe mode
    back. A robot that waits, or that has a baud rate that is not found, cannot recover by itself:
    then the node must say so, and the robot is switched off and on. LEDs, outputs and song must
    be restored then. Otherwise the test sets them again, because the robot does not report them
    and the node cannot know that they are wrong.
    """
    def attempt(stage: Stage, random: Random) -> Result:
        start_driving(stage, random)
        stage.control.tell(f'fault {" ".join(faults)}')
        printed = len(stage.node.printed)
        moving = time.monotonic() + random.uniform(0.5, 2.0)
        while time.monotonic() < moving:
            stage.publish(Twist(linear=Vector3(x=random.uniform(-0.4, 0.4))))
            stage.wait(0.05)
        stage.control.tell('fault off')
        begun = time.monotonic()
        if not follows(stage, FOLLOW_TIMEOUT):
            return power_cycled(stage, printed)
        took = time.monotonic() - begun
        stage.set_outputs()
        result = recovered(stage, Result())
        result.recovery = took
        return result
    return attempt


def follows(stage: Stage, seconds: float) -> bool:
    """Send stops and commands in turn until the robot follows; return whether it does."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        stage.publish(Twist())
        stage.publish(Twist(linear=Vector3(x=0.05)))
        stage.wait(0.1)
        if stage.watch.mode == Mode.SAFE and stage.control.truth()['right'] == 50:
            return True
    return False


def power_cycled(stage: Stage, printed: int) -> Result:
    """Check that the log, after its first `printed` lines, has advice; switch off and on."""
    log = ''.join(stage.node.printed[printed:])
    if not any(words in log for words in ADVICE):
        return Result(trouble='the robot does not follow, and the log does not say what to do')
    stage.control.tell('power off', 'after 1', 'power on')
    return recovered(stage, Result())


def told_to_wait(stage: Stage, random: Random) -> Result:
    """Send the robot a Wait that nothing ends, as damaged bytes may do."""
    start_driving(stage, random)
    printed = len(stage.node.printed)
    _write(stage, oi.WaitEvent(event=oi.Event.PLAY_BUTTON).encode())
    if follows(stage, ADVICE_TIMEOUT):
        return Result(trouble='the robot does not wait')
    return power_cycled(stage, printed)


def told_other_rate(stage: Stage, random: Random) -> Result:
    """Send the robot a Baud command, as damaged bytes may do."""
    start_driving(stage, random)
    _write(stage, oi.Baud(code=oi.BaudCode.B19200).encode())
    until_link_down(stage)
    result = recovered(stage, Result())
    stage.control.tell('power fail')
    until_link_down(stage)
    recovered(stage, Result())
    return result


def command_cut_short(stage: Stage, random: Random) -> Result:
    """Leave a command unfinished on the line, then start the node."""
    command = random.choice([
        oi.Song(number=5, notes=tuple(oi.Note(60, 20) for _ in range(16))),
        oi.DriveDirect(right=500, left=500), oi.Leds(bits=0, color=1, intensity=2),
        oi.Script(script=bytes(100)), oi.Stream(packets=tuple(range(7, 35)))]).encode()
    _write(stage, oi.Start().encode() + command[:random.randrange(1, len(command))], wait=0.05)
    return connected(stage)


def at_other_rate(stage: Stage, random: Random) -> Result:
    """Leave the robot at an unusual baud rate, then start the node with `baud: 0`."""
    _write(stage, oi.Start().encode() + oi.Baud(code=oi.BaudCode.B19200).encode(), wait=0.05)
    stage.control.tell('after 0.2')
    result = connected(stage, baud=0)
    stage.control.tell('power fail')
    return result


def _write(stage: Stage, data: bytes, *, wait: float | None = None) -> None:
    """Write bytes to the robot's port; keep it open for `wait` seconds of the robot's clock."""
    line = os.open(stage.port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, data)
    if wait is not None:
        stage.control.tell(f'after {wait}')
    os.close(line)


def connected(stage: Stage, **parameters: object) -> Result:
    """Start a node; measure from the opening of the port to the robot's answer; end the node."""
    stage.start_node(**parameters)
    assert stage.node is not None
    seconds = _logged(stage, ANSWERS) - _logged(stage, OPENED)
    stage.until(lambda: stage.control.truth()['mode'] == 'SAFE', 'Safe mode')
    stage.node.send(signal.SIGINT)
    stage.node.ended()
    return Result(recovery=seconds)


def _logged(stage: Stage, words: str) -> float:
    """Return the time stamp of the first line of the node's log that has these words."""
    line = next(line for line in stage.node.printed if words in line)
    return float(line.split('[')[2].split(']')[0])
