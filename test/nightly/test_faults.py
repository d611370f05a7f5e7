# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Faults of line, robot and process with a real node: once in `make test`, all ten times nightly.

The robot's sensors are held at fixed values: every other value that is published is wrong.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
import os
from random import Random
import signal
from statistics import median
import time

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import PlaySong, SetMode
from geometry_msgs.msg import Twist, Vector3
import pytest
from std_srvs.srv import Trigger

from create_oi_ros import oi
from create_oi_ros.driver.connection import MAX_ABSENCE
from create_oi_ros.ros.programs import PROGRAMS
from nightly.stage import jump, Pose, QUICK, SONG, Stage, staged
from support.nightly import NIGHTLY, times

SERVICE_TIMEOUT = 0.5
"""Seconds within which a service must answer when there is no robot."""
STEADY = 0.1
"""Seconds for which all must be as it was: a robot that was in Safe mode when its line came back
reports that until it gets the driver's Start, and is in Safe mode again a moment later."""


@dataclass
class Result:
    """The result of one try."""

    recovery: float | None = None
    """Seconds from the end of the fault until everything is restored and published again; a robot
    that was restarted is taken to be back MAX_ABSENCE after its last frame at the earliest."""
    zero: float | None = None
    """Seconds until the wheels had zero speed requested."""
    trouble: str = ''
    """Why the try failed, or a wrong value that was published meanwhile; empty if it did not."""


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
    zero: float = 1.0
    """Limit of `Result.zero`."""
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
        except (AssertionError, OSError) as error:
            result = Result(trouble=str(error) or repr(error))
        result.trouble = '; '.join(filter(None, (result.trouble, *stage.watch.wrong[wrong:][:1])))
        return result

    def failure(self, result: Result, slack: float) -> str:
        """Return why a try has failed; empty if it has not. `slack` is a factor for the limits."""
        limits = ((self.recovery, result.recovery, 'recovery'),
                  (self.zero, result.zero, 'zero speed'))
        late = [f'{what} after {took:.3f} s, not {limit:g} s' for limit, took, what in limits
                if limit is not None and took is not None and took > limit * slack]
        return '; '.join(filter(None, (result.trouble, *late)))


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


def recovered(stage: Stage, result: Result, *, restarted: bool = False) -> Result:
    """Wait until the wheels have stopped and everything is restored; play the song."""
    begun, odoms = time.monotonic(), stage.watch.odoms
    early = stage.watch.newest + MAX_ABSENCE - time.time() if restarted else 0.0
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
    result.recovery = back_at - begun - max(0.0, early)
    song = stage.ros.call(PlaySong, 'play_song', number=SONG)
    if not song.success:
        result.trouble = f'the song is lost: {song.message}'
    stage.until(lambda: stage.control.truth()['song_number'] == SONG, 'the song')
    stage.wait(0.2)
    return result


# Faults of the link: lost and found, damaged bytes, and a robot that is in an odd state.


ADVICE = ('switch it off and on', 'another baud rate', 'no answer at')
"""Words in the node's log that tell the user what to do with a robot that does not follow."""
FOLLOW_TIMEOUT = 6.0
"""Seconds within which a robot must follow commands again, unless it waits."""
ADVICE_TIMEOUT = 3.0
"""Seconds within which the user must be told that the robot waits."""


def losing(lose: Callable[[Stage], None], find: Callable[[Stage], None], *,
           restarts: bool = False) -> Try:
    """Return a try in which the link is lost while the wheels turn, and found again."""
    def attempt(stage: Stage, random: Random) -> Result:
        start_driving(stage, random)
        lose(stage)
        until_link_down(stage)
        result = Result()
        check_without_robot(stage, result)
        stage.wait(random.uniform(0.0, 1.0))
        find(stage)
        return recovered(stage, result, restarted=restarts)
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
    return recovered(stage, Result(), restarted=True)


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
    return recovered(stage, Result(), restarted=True)


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


def _write(stage: Stage, data: bytes) -> None:
    """Write bytes to the robot's port, as if by mistake."""
    line = os.open(stage.port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, data)
    os.close(line)


# Faults of the driver's process, and commands that end.


RAISING = """
from create_oi_ros.ros import messages, programs
def fail(*_):
    raise RuntimeError('a fault on purpose')
bumper = messages.bumper
messages.bumper = lambda message, readings: (
    fail() if readings.bumps_and_wheel_drops else bumper(message, readings))
from create_oi_ros.ros.velocity import VelocityInput
take = VelocityInput._take
VelocityInput._take = lambda commands, message: (
    fail() if message.linear.z else take(commands, message))
raise SystemExit(programs.create_node())
"""
"""A node whose bumper message and velocity callback can raise an exception."""


def ending(name: str, end: Callable[[Stage], None], exit_code: int, *, zero: float = 0.1,
           program: str = PROGRAMS['create_node']) -> Fault:
    """Return the fault that the node ends while the wheels turn."""
    def attempt(stage: Stage, random: Random) -> Result:
        stage.start_node(code=program, cmd_vel_timeout='10.0')
        start_driving(stage, random)
        begun = time.monotonic()
        end(stage)
        stage.control.truth('wait right=0 left=0 timeout=15')
        result = Result(zero=time.monotonic() - begun)
        ended = stage.node.ended()
        truth = stage.control.truth('wait speed<0.001 mode=PASSIVE')
        stage.control.tell('bump off', 'force bump_left=0 bump_right=0')
        if ended != exit_code:
            result.trouble = f'exit code {ended}, not {exit_code}'
        stage.control.tell('after 0.3')
        if stage.control.truth()['commands'] != truth['commands']:
            result.trouble = 'commands still arrive at the robot'
        return result
    return Fault(name, attempt, keeps_node=False, recovery=None, zero=zero)


def signalled(number: signal.Signals, exit_code: int) -> Fault:
    """Return the fault that a signal ends the node, with this exit code."""
    return ending(number.name, lambda stage: stage.node.send(number), exit_code)


def suspended(stage: Stage, random: Random) -> Result:
    """Stop the node's process (SIGSTOP) as the wheels turn, and continue it (SIGCONT)."""
    start_driving(stage, random)
    begun = time.monotonic()
    stage.node.send(signal.SIGSTOP)
    stage.control.truth('wait right=0 left=0 timeout=15')
    result = Result(zero=time.monotonic() - begun)
    stage.wait(random.uniform(1.2, 3.0))
    stage.node.send(signal.SIGCONT)
    return recovered(stage, result)


def commands_end(stage: Stage, random: Random) -> Result:
    """Send no more velocities."""
    start_driving(stage, random)
    return Result(zero=stage.until(stage.stopped, 'a stop'))


def told_to_stop(stage: Stage, random: Random) -> Result:
    """Call the service `stop`."""
    client = stage.ros.node.create_client(Trigger, 'stop')
    stage.until(client.service_is_ready, 'the service')
    start_driving(stage, random)
    begun = time.monotonic()
    called = client.call_async(Trigger.Request())
    stage.control.truth('wait right=0 left=0')
    result = Result(zero=time.monotonic() - begun)
    stage.until(called.done, 'the reply')
    stage.ros.node.destroy_client(client)
    result.trouble = '' if called.result().success else called.result().message
    return result


# All faults of the nightly.


BOOT = 3.0
"""Seconds that the boot loader of a robot takes."""
FAULTS = (
    Fault('cable out and in', losing(unplug, plug)),
    Fault('port renamed', losing(unplug, plug_elsewhere)),
    Fault('cable broken and mended', losing(sending('cable cut'), sending('cable mend'))),
    Fault('robot off and on', losing(
        sending('power off'), sending('power on'), restarts=True)),
    Fault('robot off and on, 3 s of boot loader', losing(
        sending('power off'), sending('power on', f'after {BOOT}')), robot=('--seed', '1')),
    Fault('battery out and in', losing(
        sending('power fail'), sending('after 1.0', f'after {BOOT - 1}')),
        robot=('--seed', '2')),
    Fault('simulator restarted', restarted),
    Fault('silence', losing(sending('fault silence@0+999999'), sending('fault off'))),
    Fault('robot deaf for a while', disturbing('deaf@0+999999')),
    Fault('bad line: 5 % flipped, short, garbage', disturbing('flip:0.05 drop:0.05 garbage:0.05')),
    Fault('all bytes garbled', disturbing('flip:1 drop:1 garbage:1')),
    Fault('bytes to the robot damaged, 10 %', damaging_commands(
        'flip.in:0.1', 'drop.in:0.1', 'garbage.in:0.1'), recovery=FOLLOW_TIMEOUT,
        zero=FOLLOW_TIMEOUT, node={'baud': 0}),
    Fault('robot told to wait for ever', told_to_wait, node={'baud': 0}),
    Fault('robot told another baud rate', told_other_rate, node={'baud': 0}),
    Fault('SIGSTOP, SIGCONT', suspended, zero=0.2),
    *(signalled(number, -number) for number in (signal.SIGKILL, signal.SIGSEGV, signal.SIGABRT)),
    *(signalled(number, 0) for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)),
    ending('exception in a subscription', lambda stage: stage.publish(
        Twist(linear=Vector3(z=1.0))), 1, zero=0.2, program=RAISING),
    ending('exception on the serial thread', sending('bump left'), 1, zero=0.2, program=RAISING),
    Fault('commands end', commands_end, recovery=None, zero=0.7),
    Fault('stop', told_to_stop, recovery=None, zero=0.1),
)
ONCE = ('cable out and in', 'bad line: 5 % flipped, short, garbage', 'SIGSTOP, SIGCONT',
        'robot told to wait for ever', 'SIGKILL')
"""Faults that `make test` makes once."""
BY_NAME = {fault.name: fault for fault in FAULTS}


@pytest.fixture(scope='module')
def stage(tmp_path_factory):
    """Return a stage whose node lives on from fault to fault."""
    with staged(tmp_path_factory.mktemp('stage')) as made:
        yield made


@pytest.mark.parametrize('name', ONCE)
def test_the_robot_stops_or_all_is_as_before(stage, name):
    fault = BY_NAME[name]
    result = fault.attempt(stage, Random(name))
    failure = fault.failure(result, inf)  # nothing is timed here: the machine may be busy
    if failure:
        failure += stage.node.output if stage.node else ''
        stage.end()
    assert not failure


@NIGHTLY
@pytest.mark.timeout(1200)
@pytest.mark.parametrize('name', BY_NAME)
def test_each_fault_is_survived_each_time_and_in_time(name, tmp_path):
    fault = BY_NAME[name]
    with staged(tmp_path) as stage:
        results = [fault.attempt(stage, Random(f'{name} {number}')) for number in range(times(10))]
    for what in ('recovery', 'zero'):
        if took := [late for each in results if (late := getattr(each, what)) is not None]:
            print(f'{what}: median {median(took):.3f} s, worst {max(took):.3f} s')
    assert not [why for each in results if (why := fault.failure(each, 1.0))]


def test_a_jump_of_the_odometry_is_seen():
    still = Pose(1000.0, 5.0, -2.0, 0.1)
    assert not jump(still, Pose(1000.015, 5.007, -2.0, 0.1))
    assert not jump(still, Pose(1001.0, 5.4, -2.0, 0.1))
    for wrong in (Pose(1000.015, 5.1, -2.0, 0.1), Pose(1000.015, 5.0, -2.0, 0.4),
                  Pose(1001.0, 6.0, -2.0, 0.1), still):
        assert jump(still, wrong)
