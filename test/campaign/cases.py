"""The faults: how each is made, and what is to happen then."""

from collections.abc import Callable
from dataclasses import dataclass, field
import os
from random import Random
import signal
import time

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import PlaySong, SetMode
from geometry_msgs.msg import Twist, Vector3
from std_srvs.srv import Trigger

from campaign.stage import QUICK, SONG, Stage
from create_oi_ros import oi
from create_oi_ros.ros.programs import PROGRAMS

BOOT = 3.0
"""Seconds that a robot's boot loader takes."""
AT_ONCE = 0.5
"""Seconds within which a service answers when there is no robot."""


@dataclass
class Outcome:
    """What came of one try."""

    recovery: float | None = None
    """Seconds from when the robot was there again until all was restored and published."""
    zero: float | None = None
    """Seconds until the wheels were told to stand."""
    wrong: list[str] = field(default_factory=list)
    """What was published and is not true."""
    trouble: str = ''
    """Why it failed."""


Try = Callable[[Stage, Random], Outcome]
"""Makes the fault once and looks what happens."""


@dataclass(frozen=True)
class Fault:
    """One kind of fault, and what is promised of it."""

    name: str
    try_once: Try
    again: bool = True
    """Whether robot and node go on to the next try."""
    recovery: float | None = 1.0
    """Seconds that recovery may take; None: there is nothing to recover."""
    zero: float | None = 1.0
    """Seconds until the wheels must have been told to stand."""
    node: dict[str, object] = field(default_factory=dict)
    """Parameters of the node."""
    robot: tuple[str, ...] = QUICK
    """Options of the robot."""

    def prepare(self, stage: Stage) -> None:
        """Set up what the fault needs, if it is not there."""
        if stage.robot is None:
            stage.start_robot(*self.robot)
        if self.again and stage.node is None:
            stage.start_node(**self.node)
            stage.furnish()


# The link is lost, and there again.


def losing(lose: Callable[[Stage], None], find: Callable[[Stage], None]) -> Try:
    """Return a try in which robot and node part while the wheels turn."""
    def attempt(stage: Stage, chance: Random) -> Outcome:
        _set_going(stage, chance)
        lose(stage)
        stage.until(lambda: stage.watch.mode == Mode.UNKNOWN, 'mode UNKNOWN')
        outcome = Outcome()
        _without_robot(stage, outcome)
        stage.rest(chance.uniform(0.0, 1.0))
        find(stage)
        return _recovered(stage, outcome)
    return attempt


def disturbing(fault: str) -> Try:
    """Return a try in which bytes go wrong for a while as the wheels turn."""
    def attempt(stage: Stage, chance: Random) -> Outcome:
        _set_going(stage, chance)
        stage.control.tell(f'fault {fault}')
        stage.rest(chance.uniform(0.5, 2.0))
        stage.control.tell('fault off')
        return _recovered(stage, Outcome())
    return attempt


NOT_HEARD = ('switch it off and on', 'another baud rate', 'no answer at')
"""Words of the driver that tell a person what to do with a robot that does not follow."""
WORDS_AFTER = 6.0
"""Seconds within which a robot follows again that can."""
TOLD_WITHIN = 3.0
"""Seconds within which a person is told of one that waits."""


def misled(*faults: str) -> Try:
    """
    Return a try in which bytes to the robot are damaged: any command may come of them.

    Recovered is: the wheels stand and a fresh command brings Safe back, by itself or, where the
    robot was told to wait or to talk at a rate that is not found, after the driver has said so
    and somebody has switched it off and on. Then LEDs, outputs and song must be back as well;
    else they are set again, for the robot does not report them.
    """
    def attempt(stage: Stage, chance: Random) -> Outcome:
        _set_going(stage, chance)
        stage.control.tell(f'fault {" ".join(faults)}')
        printed = len(stage.node.printed)
        moving = time.monotonic() + chance.uniform(0.5, 2.0)
        while time.monotonic() < moving:
            stage.say(Twist(linear=Vector3(x=chance.uniform(-0.4, 0.4))))
            stage.rest(0.05)
        stage.control.tell('fault off')
        begun = time.monotonic()
        if not follows(stage, WORDS_AFTER):
            return switched(stage, printed)
        took = time.monotonic() - begun
        stage.furnish()
        outcome = _recovered(stage, Outcome())
        outcome.recovery = took
        return outcome
    return attempt


def switched(stage: Stage, printed: int) -> Outcome:
    """Look that a person is told, from a line of the log on; do what he is told to do."""
    said = ''.join(stage.node.printed[printed:])
    if not any(words in said for words in NOT_HEARD):
        return Outcome(trouble='the robot does not follow, and nobody is told')
    stage.control.tell('power off', 'after 1', 'power on')
    return _recovered(stage, Outcome())


def told_to_wait(stage: Stage, chance: Random) -> Outcome:
    """Let the robot hear a Wait that nothing ends, as damaged bytes may be one."""
    _set_going(stage, chance)
    printed = len(stage.node.printed)
    _inject(stage, oi.WaitEvent(event=oi.Event.PLAY_BUTTON))
    if follows(stage, TOLD_WITHIN):
        return Outcome(trouble='it has not waited')
    return switched(stage, printed)


def told_other_rate(stage: Stage, chance: Random) -> Outcome:
    """Let the robot hear a Baud, as damaged bytes may be one."""
    _set_going(stage, chance)
    _inject(stage, oi.Baud(code=oi.BaudCode.B19200))
    stage.until(lambda: stage.watch.mode == Mode.UNKNOWN, 'mode UNKNOWN')
    outcome = _recovered(stage, Outcome())
    stage.control.tell('power fail')
    stage.until(lambda: stage.watch.mode == Mode.UNKNOWN, 'mode UNKNOWN')
    _recovered(stage, Outcome())
    return outcome


def _inject(stage: Stage, command: oi.Command) -> None:
    line = os.open(stage.port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, command.encode())
    os.close(line)


def follows(stage: Stage, seconds: float) -> bool:
    """Give commands and pauses until the robot follows; tell whether it does."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        stage.say(Twist())
        stage.say(Twist(linear=Vector3(x=0.05)))
        stage.rest(0.1)
        if stage.watch.mode == Mode.SAFE and stage.control.truth()['right'] == 50:
            return True
    return False


def stopped(stage: Stage, chance: Random) -> Outcome:
    """Stop the driver's process as the wheels turn, and let it go on."""
    _set_going(stage, chance)
    begun = time.monotonic()
    stage.node.send(signal.SIGSTOP)
    stage.control.truth('wait right=0 left=0 timeout=5')
    outcome = Outcome(zero=time.monotonic() - begun)
    stage.rest(chance.uniform(1.2, 3.0))
    stage.node.send(signal.SIGCONT)
    return _recovered(stage, outcome)


def restarted(stage: Stage, chance: Random) -> Outcome:
    """Kill the simulator and start another one."""
    _set_going(stage, chance)
    stage.end_robot()
    stage.until(lambda: stage.watch.mode == Mode.UNKNOWN, 'mode UNKNOWN')
    stage.start_robot()
    return _recovered(stage, Outcome())


def _set_going(stage: Stage, chance: Random) -> None:
    stage.drive(chance.uniform(0.1, 0.4), chance.uniform(-1.0, 1.0))
    stage.rest(chance.uniform(0.0, 0.2))


def _without_robot(stage: Stage, outcome: Outcome) -> None:
    """Look that nothing is made up while there is no robot."""
    parted, begun = time.time(), time.monotonic()
    reply = stage.ros.call(SetMode, 'set_mode', mode=Mode.SAFE)
    if reply.success or not reply.message or time.monotonic() - begun > AT_ONCE:
        outcome.trouble = f'set_mode without a robot: {reply}'
    stage.rest(0.1)
    if stage.watch.newest > parted:
        outcome.trouble = 'odom is published without a robot'


def _recovered(stage: Stage, outcome: Outcome) -> Outcome:
    """Wait until the wheels stand and all is as it was, and play the song."""
    begun, odoms = time.monotonic(), stage.watch.odoms

    def back() -> bool:
        if outcome.zero is None and stage.standing():
            outcome.zero = time.monotonic() - begun
        return (outcome.zero is not None and stage.watch.mode == Mode.SAFE
                and stage.watch.odoms > odoms and stage.restored())
    stage.until(back, 'recovery')
    outcome.recovery = time.monotonic() - begun
    song = stage.ros.call(PlaySong, 'play_song', number=SONG)
    if not song.success or stage.control.truth()['song_number'] != SONG:
        outcome.trouble = f'the song is gone: {song.message}'
    stage.rest(0.2)
    return outcome


def _unplug(stage: Stage) -> None:
    stage.control.tell('cable unplug')


def _plug(stage: Stage) -> None:
    stage.control.tell('cable plug')


def _plug_elsewhere(stage: Stage) -> None:
    """Let somebody else take the terminal's number first."""
    taken = os.openpty()
    try:
        _plug(stage)
    finally:
        for descriptor in taken:
            os.close(descriptor)


def _told(*lines: str) -> Callable[[Stage], None]:
    return lambda stage: stage.control.tell(*lines)


# Before the node came.


def half_said(stage: Stage, chance: Random) -> Outcome:
    """Leave a command unfinished on the line; then the node comes."""
    command = chance.choice([
        oi.Song(number=5, notes=tuple(oi.Note(60, 20) for _ in range(16))),
        oi.DriveDirect(right=500, left=500), oi.Leds(bits=0, color=1, intensity=2),
        oi.Script(script=bytes(100)), oi.Stream(packets=tuple(range(7, 35)))]).encode()
    _say(stage, oi.Start().encode() + command[:chance.randrange(1, len(command))])
    return _met(stage)


def at_other_rate(stage: Stage, chance: Random) -> Outcome:
    """Leave the robot at a rate that is not the usual one; then the node comes, looking."""
    _say(stage, oi.Start().encode() + oi.Baud(code=oi.BaudCode.B19200).encode())
    stage.control.tell('after 0.2')
    outcome = _met(stage, baud=0)
    stage.control.tell('power fail')
    return outcome


def _say(stage: Stage, said: bytes) -> None:
    line = os.open(stage.port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, said)
    stage.control.tell('after 0.05')
    os.close(line)


def _met(stage: Stage, **parameters: object) -> Outcome:
    """Start a node; see how long it takes to have the robot after it has opened the port."""
    stage.start_node(**parameters)
    assert stage.node is not None
    seconds = _logged(stage, 'robot answers') - _logged(stage, 'opened, calling')
    stage.until(lambda: stage.control.truth()['mode'] == 'SAFE', 'Safe mode')
    stage.node.send(signal.SIGINT)
    stage.node.ended()
    return Outcome(recovery=seconds)


def _logged(stage: Stage, words: str) -> float:
    """Return the time at which the node has logged something, by its own stamp."""
    line = next(line for line in stage.node.printed if words in line)
    return float(line.split('[')[2].split(']')[0])


# The driver ends.


def ending(end: Callable[[Stage], None], exit_code: int, program: str) -> Try:
    """Return a try in which the node ends while the wheels turn."""
    def attempt(stage: Stage, chance: Random) -> Outcome:
        stage.start_node(code=program, cmd_vel_timeout='10.0')
        _set_going(stage, chance)
        begun = time.monotonic()
        end(stage)
        stage.control.truth('wait right=0 left=0 timeout=5')
        outcome = Outcome(zero=time.monotonic() - begun)
        ended = stage.node.ended()
        truth = stage.control.truth('wait speed<0.001 mode=PASSIVE')
        stage.control.tell('bump off', 'force bump_left=0 bump_right=0')
        if ended != exit_code:
            outcome.trouble = f'exit code {ended}'
        stage.control.tell('after 0.3')
        if stage.control.truth()['commands'] != truth['commands']:
            outcome.trouble = 'something still speaks to the robot'
        return outcome
    return attempt


def _signalled(number: signal.Signals) -> Callable[[Stage], None]:
    return lambda stage: stage.node.send(number)


def _said(twist: Twist) -> Callable[[Stage], None]:
    return lambda stage: stage.say(twist)


FALLING = """
from create_oi_ros import convert, start
def fall(*_):
    raise RuntimeError('a fault of the campaign')
bumper = convert.bumper
convert.bumper = lambda message, readings: (
    fall() if readings.bumps_and_wheel_drops else bumper(message, readings))
from create_oi_ros.ros.node import CreateNode
hear = CreateNode._on_velocity
CreateNode._on_velocity = lambda node, twist: fall() if twist.linear.z else hear(node, twist)
raise SystemExit(start.create_node())
"""
"""A node in which two callbacks have a mistake that shows on occasion."""


# Nobody is in command.


def timed_out(stage: Stage, chance: Random) -> Outcome:
    """Say nothing more."""
    _set_going(stage, chance)
    return Outcome(zero=stage.until(stage.standing, 'a stop'))


def told_to_stop(stage: Stage, chance: Random) -> Outcome:
    """Call `stop`."""
    client = stage.ros.node.create_client(Trigger, 'stop')
    stage.until(client.service_is_ready, 'the service')
    _set_going(stage, chance)
    begun = time.monotonic()
    called = client.call_async(Trigger.Request())
    stage.control.truth('wait right=0 left=0')
    outcome = Outcome(zero=time.monotonic() - begun)
    stage.until(called.done, 'the reply')
    stage.ros.node.destroy_client(client)
    outcome.trouble = '' if called.result().success else called.result().message
    return outcome


def _ends(name: str, end: Callable[[Stage], None], zero: float, exit_code: int,
          program: str = PROGRAMS['create_node']) -> Fault:
    return Fault(
        name, ending(end, exit_code, program), again=False, recovery=None, zero=zero)


def _killed(number: signal.Signals) -> Fault:
    return _ends(number.name, _signalled(number), 0.1, -number)


def _ended(number: signal.Signals) -> Fault:
    return _ends(number.name, _signalled(number), 0.1, 0)


FAULTS = (
    Fault('cable out and in', losing(_unplug, _plug)),
    Fault('port renamed', losing(_unplug, _plug_elsewhere)),
    Fault('cable broken and mended', losing(_told('cable cut'), _told('cable mend'))),
    Fault('robot off and on', losing(_told('power off'), _told('power on'))),
    Fault('robot off and on, 3 s of boot loader', losing(
        _told('power off'), _told('power on', f'after {BOOT}')), robot=('--seed', '1')),
    Fault('battery out and in', losing(
        _told('power fail'), _told('after 1.0', f'after {BOOT - 1}')), robot=('--seed', '2')),
    Fault('simulator restarted', restarted),
    Fault('silence', losing(_told('fault silence@0+999999'), _told('fault off'))),
    Fault('robot deaf for a while', disturbing('deaf@0+999999')),
    Fault('bad line: 5 % flipped, short, garbage', disturbing('flip:0.05 drop:0.05 garbage:0.05')),
    Fault('all bytes garbled', disturbing('flip:1 drop:1 garbage:1')),
    Fault('bytes to the robot damaged, 10 %', misled(
        'flip.in:0.1', 'drop.in:0.1', 'garbage.in:0.1'), recovery=WORDS_AFTER,
        zero=WORDS_AFTER, node={'baud': 0}),
    Fault('robot told to wait for ever', told_to_wait, node={'baud': 0}),
    Fault('robot told another baud rate', told_other_rate, node={'baud': 0}),
    Fault('command cut short before connecting', half_said, again=False, zero=None),
    Fault('robot at 19200, baud: 0', at_other_rate, again=False, zero=None),
    Fault('SIGSTOP, SIGCONT', stopped, zero=0.2),
    *map(_killed, (signal.SIGKILL, signal.SIGSEGV, signal.SIGABRT)),
    *map(_ended, (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)),
    _ends('exception in a subscription', _said(Twist(linear=Vector3(z=1.0))), 0.2, 1, FALLING),
    _ends('exception on the serial thread', _told('bump left'), 0.2, 1, FALLING),
    Fault('commands end', timed_out, recovery=None, zero=0.7),
    Fault('stop', told_to_stop, recovery=None, zero=0.1),
)
