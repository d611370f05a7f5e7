# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The control socket: lines that change the simulated world or ask about it.

Every line is answered by one line that starts with `ok` or `error`. `help` lists the words.
"""

from collections.abc import Callable
from contextlib import suppress
import errno
import json
import math
import operator
import os
from pathlib import Path
import re
import socket
import stat
from typing import Any, NamedTuple, TYPE_CHECKING

from .. import number, TOLERANCE
from ..body.sensed import RANGES
from ..firmware import Create
from ..world import Pose
from ..world.floor_plan import outlines
from .faults import Fault, Faults
from .lines import Line, naming, PathLock

if TYPE_CHECKING:
    from ..world.lidar import Lidar

BUTTON_PRESS = 0.2
"""Default of how long a button is pressed, seconds."""
WAIT_TIMEOUT = 10.0
"""Default of the timeout of `wait`, seconds."""
LONGEST_LINE = 4096
"""Bytes; a client that sends more without an end of line is disconnected."""
COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    '>=': operator.ge, '<=': operator.le, '!=': operator.ne,
    '=': operator.eq, '>': operator.gt, '<': operator.lt,
}
CONDITION = re.compile(r'(\w+)(>=|<=|!=|=|>|<)(.+)')
NAMED_VALUES = {'true': True, 'false': False, 'none': None}


class Waiting(NamedTuple):
    """
    A `wait` or `after` that has no answer yet.

    Its condition is first checked after the next slot, when earlier lines have had their effect.
    """

    met: Callable[[], bool]
    answer: Callable[[], str]
    words: str
    since: float
    """Seconds on the robot's clock, as is the next."""
    deadline: float = math.inf

    def answer_at(self, time: float) -> str | None:
        """Return the answer at this time on the robot's clock, in seconds; None: not yet."""
        if time > self.since and self.met():
            return self.answer()
        if time >= self.deadline:
            return f'error timeout while waiting for {self.words}'
        return None


class ControlWord(NamedTuple):
    """What a word does, its form and its meaning."""

    execute: Callable[..., str | Waiting | None]
    form: str
    meaning: str


WORDS: dict[str, ControlWord] = {}
Obey = Callable[['Interpreter', list[str]], str | Waiting | None]


def word(form: str, meaning: str) -> Callable[[Obey], Obey]:
    """Make a method that is called `do_NAME` the meaning of the word NAME."""
    def declare(method: Obey) -> Obey:
        WORDS[method.__name__.removeprefix('do_')] = ControlWord(method, form, meaning)
        return method
    return declare


class Interpreter:
    """Runs the lines that arrive on the control socket."""

    def __init__(self, create: Create, line: Line, faults: Faults,
                 stop: Callable[[], None]) -> None:
        self._create, self._body = create, create.body
        self._line, self._faults, self._stop = line, faults, stop
        self._now = 0.0
        self._lidar: Lidar | None = None

    def step(self) -> None:
        """Turn the lidar, if anybody has asked for a scan; called after every slot."""
        if self._lidar is not None:
            self._lidar.step(self._create.time, self._body.truth().pose)

    def execute(self, text: str, now: float) -> str | Waiting:
        """Run a line; return the answer or what waits for it. No text raises."""
        self._now = now
        name, *words = text.split() or ['']
        if name not in WORDS:
            return f'error unknown word {name!r}: try help' if name else (
                'error empty line: try help')
        try:
            answer = WORDS[name].execute(self, words)
        except (ValueError, OSError) as error:
            return f'error {name}: {error}'.replace('\n', ' ')
        return 'ok' if answer is None else answer

    def facts(self) -> dict[str, Any]:
        create, truth = self._create, self._body.truth()
        actuators, speaker = create.actuators, create.speaker
        return {
            'time': round(create.time, 6), **truth.pose._asdict(), 'speed': truth.speed,
            'rate': truth.rate, 'travelled': truth.travelled, 'turned': truth.turned,
            'measured_travelled': truth.measured_travelled,
            'measured_turned': truth.measured_turned,
            'mode': create.mode.name, 'powered': create.powered, 'baud': create.baud,
            'demo': create.demo.name if create.demo is not None else None,
            'right': actuators.wheels.right, 'left': actuators.wheels.left,
            'frames': create.frames, 'commands': create.commands, 'waiting': create.waiting,
            'song_number': speaker.number, 'song_playing': speaker.song_playing(create.time),
            'note': create.note, 'leds': int(create.lights.bits),
            'power_color': create.lights.color, 'power_intensity': create.lights.intensity,
            'outputs': int(create.outputs), 'duties': list(actuators.duties),
            'infrared_sent': list(actuators.infrared_sent), 'cable_cut': self._faults.cable_cut,
        }

    def _known(self) -> dict[str, Any]:
        return {**self.facts(), **self._body.sense()._asdict()}

    @word('', 'list the words')
    def do_help(self, words: list[str]) -> str:
        return 'ok ' + '; '.join(f'{name} {word.form}: {word.meaning}'.replace(' :', ':')
                                 for name, word in WORDS.items())

    @word('', 'pose, velocities (m, rad, s), mode, wheels (mm/s), all else, as JSON')
    def do_truth(self, words: list[str]) -> str:
        return self._truth()

    def _truth(self) -> str:
        return 'ok ' + json.dumps(self.facts())

    @word('', 'what the sensors see, as JSON')
    def do_sense(self, words: list[str]) -> str:
        return 'ok ' + json.dumps(self._body.sense()._asdict())

    @word('', 'what stands in the room, in metres, as JSON')
    def do_room(self, words: list[str]) -> str:
        return 'ok ' + json.dumps(outlines(self._body.world))

    @word('', "the lidar's next whole turn: 360 ranges in m, and its age in s, as JSON")
    def do_scan(self, words: list[str]) -> Waiting:
        if self._lidar is None:
            from ..world.lidar import Lidar  # here: numpy takes long to import
            self._lidar = Lidar(self._body.world, self._create.time, self._body.truth().pose)
        lidar, seen = self._lidar, self._lidar.scans
        return Waiting(lambda: lidar.scans > seen,
                       lambda: 'ok ' + json.dumps(lidar.report(self._create.time)),
                       'a scan', self._create.time)

    @word('NAME=VALUE ... [timeout=S]',
          'answer when truth or sense meet these (also != < > <= >=)')
    def do_wait(self, words: list[str]) -> Waiting:
        known, timeout = self._known(), WAIT_TIMEOUT
        conditions: list[tuple[str, Callable[[Any, Any], bool], Any]] = []
        for word in words:
            match = CONDITION.fullmatch(word)
            if match is None:
                raise ValueError(f'{word!r} is no condition; allowed: such as mode=SAFE or x>0.5')
            name, compare, value = match[1], COMPARE[match[2]], _value(match[3])
            if name == 'timeout':
                timeout = number(match[3])
                continue
            if name not in known:
                raise ValueError(f'no {name!r}; allowed: {", ".join(known)}')
            if compare not in (operator.eq, operator.ne) and not (
                    isinstance(value, float) and isinstance(known[name], int | float)):
                raise ValueError(f'{name} and {value!r} are not both numbers; allowed: = and !=')
            conditions.append((name, compare, value))

        def met() -> bool:
            facts = self._known()
            return all(compare(facts[name], value) for name, compare, value in conditions)
        time = self._create.time
        return Waiting(met, self._truth, ' '.join(words), time, time + timeout)

    @word('SECONDS', "answer this much later on the robot's clock")
    def do_after(self, words: list[str]) -> Waiting:
        seconds, = _numbers(words, 1)
        time = self._create.time
        end = time + seconds - TOLERANCE
        return Waiting(lambda: self._create.time >= end, self._truth,
                       f'{seconds} s', time)

    @word('left|right|both|off [SECONDS]', 'press the bumper')
    def do_bump(self, words: list[str]) -> None:
        side, seconds = _choice(words, 'left', 'right', 'both', 'off'), _seconds(words, math.inf)
        self._body.unforce('bump_left', 'bump_right')
        if side != 'off':
            self._body.force(seconds=seconds, bump_left=side in ('left', 'both'),
                             bump_right=side in ('right', 'both'))

    @word('play|advance [SECONDS]', 'press a button')
    def do_button(self, words: list[str]) -> None:
        name = _choice(words, 'play', 'advance')
        self._body.force(seconds=_seconds(words, BUTTON_PRESS), **{name: 1})

    @word('NAME=VALUE ... [seconds=S]', 'hold sensors (the names of sense) at values')
    def do_force(self, words: list[str]) -> None:
        values = _assignments(words, (*RANGES, 'seconds'))
        seconds = values.pop('seconds', math.inf)
        whole = {name: int(value) for name, value in values.items() if value == int(value)}
        if not values or len(whole) < len(values):
            raise ValueError('allowed: whole numbers, such as bump_left=1 infrared=130')
        self._body.force(seconds=seconds, **whole)

    @word('[NAME ...]', 'give sensors back to the physics')
    def do_unforce(self, words: list[str]) -> None:
        self._body.unforce(*words)

    @word('', 'take the robot off the floor')
    def do_lift(self, words: list[str]) -> None:
        self._body.lift(True)

    @word('', 'put the robot back on the floor')
    def do_down(self, words: list[str]) -> None:
        self._body.lift(False)

    @word('[right] [left] [caster]', 'let these wheels and no others hang down')
    def do_drop(self, words: list[str]) -> None:
        self._body.drop(**_flags(words, 'right', 'left', 'caster'))

    @word('[right] [left]', 'hold these wheels and no others')
    def do_hold(self, words: list[str]) -> None:
        self._body.hold(**_flags(words, 'right', 'left'))

    @word('SPEED RATE SECONDS', 'roll the robot by hand (m/s, rad/s)')
    def do_push(self, words: list[str]) -> None:
        speed, rate, seconds = _numbers(words, 3)
        self._body.push(speed=speed, rate=rate, seconds=seconds)

    @word('RIGHT LEFT SECONDS', 'let the wheels lose these parts (0 to 1) of their travel')
    def do_slip(self, words: list[str]) -> None:
        right, left, seconds = _numbers(words, 3)
        self._body.slip(right=right, left=left, seconds=seconds)

    @word('X Y YAW', 'put the robot elsewhere (metres, degrees)')
    def do_place(self, words: list[str]) -> None:
        x, y, yaw = _numbers(words, 3)
        self._body.place(Pose(x, y, math.radians(yaw)))

    @word('[ld0=A] [ld1=A] [ld2=A]', 'connect loads (amperes) to the low side drivers')
    def do_load(self, words: list[str]) -> None:
        self._body.load(**_assignments(words, ('ld0', 'ld1', 'ld2')))

    @word('on|off', 'plug in the internal charger')
    def do_charger(self, words: list[str]) -> None:
        self._body.plug_charger(_choice(words, 'on', 'off') == 'on')

    @word('on|off', 'switch the Home Bases on or off')
    def do_dock(self, words: list[str]) -> None:
        self._body.power_home_base(_choice(words, 'on', 'off') == 'on')

    @word('[charge=0..1] [temperature=C] [fault=0|1] [waits=0|1]', 'set the battery and a charger')
    def do_battery(self, words: list[str]) -> None:
        values: dict[str, Any] = _assignments(words, ('charge', 'temperature', 'fault', 'waits'))
        for name in {'fault', 'waits'} & values.keys():
            values[name] = bool(values[name])
        self._body.set_battery(**values)

    @word('on|off|toggle|fail',
          'press the power button; fail: take the battery out and put it back')
    def do_power(self, words: list[str]) -> None:
        match _choice(words, 'on', 'off', 'toggle', 'fail'):
            case 'toggle':
                self._create.power(not self._create.powered, self._now)
            case 'fail':
                self._create.lose_battery(self._now)
            case state:
                self._create.power(state == 'on', self._now)

    @word('cut|mend|unplug|plug', 'lose all bytes; remove the port; undo each')
    def do_cable(self, words: list[str]) -> None:
        match _choice(words, 'cut', 'mend', 'unplug', 'plug'):
            case 'unplug':
                self._line.unplug()
            case 'plug':
                self._line.plug()
            case state:
                self._faults.cable_cut = state == 'cut'

    @word('SPEC ...|off', 'replace the faults by these (as in --fault), or by none')
    def do_fault(self, words: list[str]) -> None:
        self._faults.faults = [] if words == ['off'] else [Fault.parse(word) for word in words]

    @word('', 'end the simulator')
    def do_quit(self, words: list[str]) -> None:
        self._stop()


def _numbers(words: list[str], count: int) -> list[float]:
    if len(words) != count:
        raise ValueError(f'{len(words)} numbers; allowed: {count}')
    return [number(word) for word in words]


def _seconds(words: list[str], otherwise: float) -> float:
    return number(words[1]) if len(words) > 1 else otherwise


def _choice(words: list[str], *allowed: str) -> str:
    if not words or words[0] not in allowed:
        raise ValueError(f'allowed: {", ".join(allowed)}')
    return words[0]


def _flags(words: list[str], *allowed: str) -> dict[str, bool]:
    for word in words:
        _choice([word], *allowed)
    return {name: name in words for name in allowed}


def _assignments(words: list[str], allowed: tuple[str, ...]) -> dict[str, float]:
    values = {}
    for word in words:
        name, _, value = word.partition('=')
        _choice([name], *allowed)
        values[name] = number(value)
    return values


def _value(text: str) -> Any:
    """Return the value of a condition: true, false, none, a number, or else the text."""
    if text.lower() in NAMED_VALUES:
        return NAMED_VALUES[text.lower()]
    try:
        return float(text)
    except ValueError:
        return text


class ControlConnection:
    """One client: its bytes that are not yet obeyed, and the wait it is blocked on."""

    def __init__(self, connection: socket.socket) -> None:
        self.socket = connection
        self.received = b''
        self.waiting: Waiting | None = None
        self.gone = False


class ControlPort:
    """Serves any number of clients; a client that waits does not block the others."""

    def __init__(self, path: Path, control: Interpreter) -> None:
        """
        Listen; OSError names the path if that cannot be.

        FileExistsError: it is no socket, or belongs to a live simulator.
        """
        self._path, self._control = path, control
        with naming(path):
            exists = path.exists() or path.is_symlink()
            if exists and not stat.S_ISSOCK(os.lstat(path).st_mode):
                raise FileExistsError(errno.EEXIST, 'is no socket, so it is kept')
            self._lock = PathLock(path)
            path.unlink(missing_ok=True)
            self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            self._listener.bind(str(path))
            self._listener.listen()
        self._listener.setblocking(False)
        self._inode = os.stat(path).st_ino
        self._clients: list[ControlConnection] = []

    def watched(self) -> list[int]:
        """Return the descriptors that become readable when `serve` has something to do."""
        return [self._listener.fileno(), *(each.socket.fileno() for each in self._clients)]

    def serve(self, time: float) -> None:
        """Read and answer all clients; `time` is the robot's clock, in seconds."""
        with suppress(BlockingIOError):
            connection, _ = self._listener.accept()
            connection.setblocking(False)
            self._clients.append(ControlConnection(connection))
        for client in self._clients:
            self._read(client)
            self._answer(client, time)
        for client in self._clients:
            if client.gone:
                client.socket.close()
        self._clients = [each for each in self._clients if not each.gone]

    def _read(self, client: ControlConnection) -> None:
        try:
            data = client.socket.recv(LONGEST_LINE)
        except BlockingIOError:
            return
        except OSError:
            data = b''
        client.received += data
        client.gone = not data or len(client.received) > 2 * LONGEST_LINE

    def _answer(self, client: ControlConnection, time: float) -> None:
        while not client.gone:
            if client.waiting is not None:
                answer = client.waiting.answer_at(time)
                if answer is None:
                    return
                client.waiting = None
                self._send(client, answer)
                continue
            line, end, rest = client.received.partition(b'\n')
            if not end:
                return
            client.received = rest
            result = self._control.execute(line.decode('utf-8', 'replace'), time)
            if isinstance(result, Waiting):
                client.waiting = result
            else:
                self._send(client, result)

    def _send(self, client: ControlConnection, text: str) -> None:
        try:
            client.socket.sendall(text.encode() + b'\n')
        except OSError:
            client.gone = True

    def close(self) -> None:
        """Disconnect all clients and remove the socket."""
        for client in self._clients:
            client.socket.close()
        self._listener.close()
        with suppress(OSError):
            if os.stat(self._path).st_ino == self._inode:
                self._path.unlink()
        self._lock.release()
