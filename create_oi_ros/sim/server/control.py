# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The language of the control socket: lines that change the simulated world or ask about it.

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
from typing import Any, NamedTuple

from ..body.sensed import RANGES
from ..firmware import Create
from ..numbers import number, TOLERANCE
from ..world import Pose
from ..world.floor_plan import outlines
from .faults import Fault, Faults
from .lines import Claim, Line, naming

PRESS = 0.2
"""Default of how long a button is pressed, seconds."""
WAIT_TIMEOUT = 10.0
"""Default of the timeout of `wait`, seconds."""
COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    '>=': operator.ge, '<=': operator.le, '!=': operator.ne,
    '=': operator.eq, '>': operator.gt, '<': operator.lt,
}
CONDITION = re.compile(r'(\w+)(>=|<=|!=|=|>|<)(.+)')


class Waiting:
    """
    A `wait` or `after` that has no answer yet.

    Its condition is first checked after the next slot, when earlier lines have had their effect.
    """

    def __init__(self, met: Callable[[], bool], since: float, deadline: float,
                 truth: Callable[[], str], words: str) -> None:
        self._met, self._since, self._deadline = met, since, deadline
        self._truth, self._words = truth, words

    def answer(self, time: float) -> str | None:
        """Return the answer at this time on the robot's clock, in seconds; None: not yet."""
        if time <= self._since:
            return None
        if self._met():
            return self._truth()
        if time >= self._deadline:
            return f'error timeout while waiting for {self._words}'
        return None


class Interpreter:
    """Runs the lines that arrive on the control socket."""

    def __init__(self, create: Create, line: Line, faults: Faults,
                 stop: Callable[[], None]) -> None:
        self._create, self._body = create, create.body
        self._line, self._faults, self._stop = line, faults, stop
        self._now = 0.0

    def obey(self, text: str, now: float) -> str | Waiting:
        """Run a line; return the answer or what waits for it. No text raises."""
        self._now = now
        words = text.split()
        if not words:
            return 'error empty line: try help'
        word = WORDS.get(words[0])
        if word is None:
            return f'error unknown word {words[0]!r}: try help'
        try:
            answer = word.obey(self, words[1:])
        except (ValueError, OSError) as error:
            return f'error {words[0]}: {error}'.replace('\n', ' ')
        return 'ok' if answer is None else answer

    # Questions.

    def _help(self, words: list[str]) -> str:
        return 'ok ' + '; '.join(f'{name} {word.form}: {word.meaning}'.replace(' :', ':')
                                 for name, word in WORDS.items())

    def facts(self) -> dict[str, Any]:
        """Return the true motion and the robot's state."""
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

    def _truth(self, words: list[str]) -> str:
        return 'ok ' + json.dumps(self.facts())

    def _sense(self, words: list[str]) -> str:
        return 'ok ' + json.dumps(self._body.sense()._asdict())

    def _room(self, words: list[str]) -> str:
        return 'ok ' + json.dumps(outlines(self._body.world))

    def _wait(self, words: list[str]) -> Waiting:
        conditions, timeout = [], WAIT_TIMEOUT
        for word in words:
            match = CONDITION.fullmatch(word)
            if match is None:
                raise ValueError(f'{word!r} is no condition; allowed: such as mode=SAFE or x>0.5')
            if match[1] == 'timeout':
                timeout = number(match[3])
            else:
                conditions.append((match[1], COMPARE[match[2]], _value(match[3])))
        return self._waiting(conditions, timeout, ' '.join(words))

    def _waiting(self, conditions: list[tuple[str, Callable[[Any, Any], bool], Any]],
                 timeout: float, words: str) -> Waiting:
        known = self._known()
        for name, compare, value in conditions:
            if name not in known:
                raise ValueError(f'no {name!r}; allowed: {", ".join(known)}')
            if compare not in (operator.eq, operator.ne) and not (
                    isinstance(value, float) and isinstance(known[name], int | float)):
                raise ValueError(f'{name} and {value!r} are not both numbers; allowed: = and !=')

        def met() -> bool:
            facts = self._known()
            return all(compare(facts[name], value) for name, compare, value in conditions)
        time = self._create.time
        return Waiting(met, time, time + timeout, lambda: self._truth([]), words)

    def _known(self) -> dict[str, Any]:
        return {**self.facts(), **self._body.sense()._asdict()}

    def _after(self, words: list[str]) -> Waiting:
        seconds, = _numbers(words, 1)
        time = self._create.time
        end = time + seconds - TOLERANCE
        return Waiting(lambda: self._create.time >= end, time, math.inf,
                       lambda: self._truth([]), f'{seconds} s')

    # The robot's surroundings.

    def _bump(self, words: list[str]) -> None:
        side, seconds = _choice(words, 'left', 'right', 'both', 'off'), _seconds(words, math.inf)
        self._body.unforce('bump_left', 'bump_right')
        pressed = {'bump_left': side in ('left', 'both'), 'bump_right': side in ('right', 'both')}
        if side != 'off':
            self._body.force(seconds=seconds, **pressed)

    def _button(self, words: list[str]) -> None:
        name = _choice(words, 'play', 'advance')
        self._body.force(seconds=_seconds(words, PRESS), **{name: 1})

    def _force(self, words: list[str]) -> None:
        values = _assignments(words, (*RANGES, 'seconds'))
        seconds = values.pop('seconds', math.inf)
        whole = {name: int(value) for name, value in values.items() if value == int(value)}
        if not values or len(whole) < len(values):
            raise ValueError('allowed: whole numbers, such as bump_left=1 infrared=130')
        self._body.force(seconds=seconds, **whole)

    def _unforce(self, words: list[str]) -> None:
        self._body.unforce(*words)

    def _lift(self, words: list[str]) -> None:
        self._body.lift(True)

    def _down(self, words: list[str]) -> None:
        self._body.lift(False)

    def _drop(self, words: list[str]) -> None:
        self._body.drop(**_flags(words, 'right', 'left', 'caster'))

    def _hold(self, words: list[str]) -> None:
        self._body.hold(**_flags(words, 'right', 'left'))

    def _push(self, words: list[str]) -> None:
        speed, rate, seconds = _numbers(words, 3)
        self._body.push(speed=speed, rate=rate, seconds=seconds)

    def _slip(self, words: list[str]) -> None:
        right, left, seconds = _numbers(words, 3)
        self._body.slip(right=right, left=left, seconds=seconds)

    def _place(self, words: list[str]) -> None:
        x, y, yaw = _numbers(words, 3)
        self._body.place(Pose(x, y, math.radians(yaw)))

    def _load(self, words: list[str]) -> None:
        self._body.load(**_assignments(words, ('ld0', 'ld1', 'ld2')))

    # Power.

    def _charger(self, words: list[str]) -> None:
        self._body.plug_charger(_choice(words, 'on', 'off') == 'on')

    def _dock(self, words: list[str]) -> None:
        self._body.power_home_base(_choice(words, 'on', 'off') == 'on')

    def _battery(self, words: list[str]) -> None:
        values: dict[str, Any] = _assignments(words, ('charge', 'temperature', 'fault'))
        if 'fault' in values:
            values['fault'] = bool(values['fault'])
        self._body.set_battery(**values)

    def _power(self, words: list[str]) -> None:
        match _choice(words, 'on', 'off', 'toggle', 'fail'):
            case 'toggle':
                self._create.toggle_power(self._now)
            case 'fail':
                self._create.lose_battery(self._now)
            case state:
                self._create.power(state == 'on', self._now)

    # The line.

    def _cable(self, words: list[str]) -> None:
        match _choice(words, 'cut', 'mend', 'unplug', 'plug'):
            case 'unplug':
                self._line.unplug()
            case 'plug':
                self._line.plug()
            case state:
                self._faults.cable_cut = state == 'cut'

    def _fault(self, words: list[str]) -> None:
        self._faults.faults = [] if words == ['off'] else [Fault.parse(word) for word in words]

    def _quit(self, words: list[str]) -> None:
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
    named = {'true': True, 'false': False, 'none': None}
    if text.lower() in named:
        return named[text.lower()]
    try:
        return float(text)
    except ValueError:
        return text


class ControlWord(NamedTuple):
    """What a word does, its form and its meaning."""

    obey: Callable[[Interpreter, list[str]], str | Waiting | None]
    form: str
    meaning: str


WORDS = {
    'help': ControlWord(Interpreter._help, '', 'list the words'),
    'truth': ControlWord(
        Interpreter._truth, '',
        'pose, velocities (m, rad, s), mode, wheels (mm/s), all else, as JSON'),
    'sense': ControlWord(Interpreter._sense, '', 'what the sensors see, as JSON'),
    'room': ControlWord(
        Interpreter._room, '', 'what stands in the room, in metres, as JSON'),
    'wait': ControlWord(
        Interpreter._wait, 'NAME=VALUE ... [timeout=S]',
        'answer when truth or sense meet these (also != < > <= >=)'),
    'after': ControlWord(
        Interpreter._after, 'SECONDS',
        "answer this much later on the robot's clock"),
    'bump': ControlWord(Interpreter._bump, 'left|right|both|off [SECONDS]', 'press the bumper'),
    'button': ControlWord(Interpreter._button, 'play|advance [SECONDS]', 'press a button'),
    'force': ControlWord(
        Interpreter._force, 'NAME=VALUE ... [seconds=S]',
        'hold sensors (the names of sense) at values'),
    'unforce': ControlWord(Interpreter._unforce, '[NAME ...]', 'give sensors back to the physics'),
    'lift': ControlWord(Interpreter._lift, '', 'take the robot off the floor'),
    'down': ControlWord(Interpreter._down, '', 'put the robot back on the floor'),
    'drop': ControlWord(
        Interpreter._drop, '[right] [left] [caster]',
        'let these wheels and no others hang down'),
    'hold': ControlWord(Interpreter._hold, '[right] [left]', 'hold these wheels and no others'),
    'push': ControlWord(
        Interpreter._push, 'SPEED RATE SECONDS',
        'roll the robot by hand (m/s, rad/s)'),
    'slip': ControlWord(
        Interpreter._slip, 'RIGHT LEFT SECONDS',
        'let the wheels lose these parts (0 to 1) of their travel'),
    'place': ControlWord(
        Interpreter._place, 'X Y YAW',
        'put the robot elsewhere (metres, degrees)'),
    'load': ControlWord(
        Interpreter._load, '[ld0=A] [ld1=A] [ld2=A]',
        'connect loads (amperes) to the low side drivers'),
    'charger': ControlWord(Interpreter._charger, 'on|off', 'plug in the internal charger'),
    'dock': ControlWord(Interpreter._dock, 'on|off', 'switch the Home Bases on or off'),
    'battery': ControlWord(
        Interpreter._battery, '[charge=0..1] [temperature=C] [fault=0|1]',
        'set the state of the battery'),
    'power': ControlWord(
        Interpreter._power, 'on|off|toggle|fail',
        'press the power button; fail: take the battery out and put it back'),
    'cable': ControlWord(
        Interpreter._cable, 'cut|mend|unplug|plug',
        'lose all bytes; remove the port; undo each'),
    'fault': ControlWord(
        Interpreter._fault, 'SPEC ...|off',
        'replace the faults by these (as in --fault), or by none'),
    'quit': ControlWord(Interpreter._quit, '', 'end the simulator'),
}


LONGEST_LINE = 4096
"""Bytes; a client that sends more without an end of line is disconnected."""


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
            self._claim = Claim(path)
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

    @property
    def waited_on(self) -> bool:
        """Whether a client waits for something to happen."""
        return any(each.waiting is not None for each in self._clients)

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
                answer = client.waiting.answer(time)
                if answer is None:
                    return
                client.waiting = None
                self._send(client, answer)
                continue
            line, end, rest = client.received.partition(b'\n')
            if not end:
                return
            client.received = rest
            result = self._control.obey(line.decode('utf-8', 'replace'), time)
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
        self._claim.release()
