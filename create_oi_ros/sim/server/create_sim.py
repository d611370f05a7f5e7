# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The program `create_sim`: its options, and what it prints."""

import argparse
import atexit
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
import csv
from dataclasses import replace
import errno
from pathlib import Path
import re
import signal
import socket
import sys
from typing import TypeVar

from ...oi import Checksum
from ...oi.tools.capture_format import CaptureError
from ...robot import Rounding
from ..body import Body
from ..body.config import BodyConfig
from ..firmware import Create
from ..firmware.guesses import Guesses, parse_guesses
from ..world import shipped_names, World, WorldError
from ..world.floor_plan import map_of
from ..world_files import read_world
from .control import ControlPort
from .faults import Fault, Faults
from .lines import Line, naming, PtyLine, TcpLine
from .replay import play, Player
from .serve import Server

REPLAY_HAS = ('replay', 'link', 'tcp', 'speed')
"""Options that work with --replay."""
Value = TypeVar('Value')


def _address(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(':')
    if not port.isdecimal() or int(port) > 65535:
        raise argparse.ArgumentTypeError(f'{text!r}; allowed: HOST:PORT or :PORT')
    return host.strip('[]') or '127.0.0.1', int(port)


def _told(read: Callable[[str], Value]) -> Callable[[str], Value]:
    """Return a function that reads an option, of whose errors argparse shows the words."""
    def told(text: str) -> Value:
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
    return told


def _export(text: str) -> Path:
    if Path(text).suffix != '.yaml':
        raise argparse.ArgumentTypeError(f'{text!r}; allowed: a file that ends with .yaml')
    return Path(text)


def _number(low: float, high: float) -> Callable[[str], float]:
    """Return a function that reads a number in a range."""
    def read(text: str) -> float:
        with suppress(ValueError):
            if low <= (value := float(text)) <= high:
                return value
        raise argparse.ArgumentTypeError(f'{text!r}; allowed: {low:g} to {high:g}')
    return read


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='create_sim',
        description='Serve a simulated iRobot Create as a serial port, until Ctrl-C.')
    add = parser.add_argument
    where = parser.add_mutually_exclusive_group()
    where.add_argument('--link', type=Path, metavar='PATH',
                       help='symbolic link to the pseudo terminal')
    where.add_argument('--tcp', type=_address, metavar='HOST:PORT',
                       help='serve socket:// clients instead (no host: loopback only)')
    add('--world', type=_told(read_world), default='empty', metavar='NAME|FILE',
        help=f'{", ".join(shipped_names())}, or a file (default: %(default)s)')
    add('--odometry', choices=[each.value for each in Rounding],
        default=Rounding.TRUNCATE.value,
        help='what reading distance and angle does with fractions (default: %(default)s)')
    add('--checksum', choices=[each.value for each in Checksum],
        default=Checksum.HARDWARE.value,
        help='of stream frames: without the header (manual) or with it (default: %(default)s)')
    add('--guess', action='append', default=[], metavar='NAME=VALUE',
        help='change a guess about what the manual leaves open; see docs/simulator_guesses.md')
    add('--fault', action='append', type=_told(Fault.parse), default=[], metavar='SPEC',
        help='cause a fault, such as flip:0.05 or unplug@20+3; see docs/simulator.md')
    add('--gyro', action='store_true', help='put a gyro on the analog input of the cargo bay')
    add('--seed', type=int, default=0, help='of all random numbers (default: %(default)s)')
    add('--speed', type=_number(0.001, 1000), default=1.0,
        help='times real time (default: %(default)s)')
    add('--control', type=Path, metavar='PATH', help='Unix socket that changes the world')
    add('--say', metavar='LINE', help='send a line, such as "bump left", to the robot that has '
        'the socket of --control, print its answer, and end; "help" lists the lines')
    add('--record', type=Path, metavar='FILE.csv', help='write the truth, a row each 15 ms')
    add('--export', type=_export, metavar='FILE.yaml',
        help='write the world as a map for Nav2 (YAML and PGM, 2 cm a cell), and end; nothing '
        'is simulated')
    add('--linger', type=_number(0, 60), default=0.0, metavar='SECONDS',
        help='at Ctrl-C, serve so long or until the host has closed the port '
        '(default: %(default)s); a second Ctrl-C ends at once')
    add('--replay', type=Path, metavar='FILE',
        help="send again what the robot sent in FILE, written by the driver's parameter "
        '`capture`; starts when a host sends a byte, nothing is simulated')
    return parser


def _line(options: argparse.Namespace) -> Line:
    return TcpLine(*options.tcp) if options.tcp else PtyLine(options.link)


def _end_on_signals(serving: Server | Player) -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: serving.stop())
        # `ros2 launch` sends another one, which must not kill what ends already.
        atexit.register(signal.signal, number, signal.SIG_IGN)


def _recorder(server: Server, path: Path, stack: ExitStack) -> Callable[[], None]:
    """Return a function that writes a row of the truth; OSError names the file."""
    stack.enter_context(naming(path))
    file = stack.enter_context(path.open('w', newline=''))
    names = [name for name, value in server.control.facts().items()
             if not isinstance(value, list)]
    writer = csv.DictWriter(file, names, extrasaction='ignore')

    def write() -> None:
        with naming(path):
            writer.writerow(server.control.facts())
    writer.writeheader()
    return write


def _announce(options: argparse.Namespace, line: Line) -> None:
    print(f'A simulated Create is on {line.name} (world {options.world.name}, odometry '
          f'{options.odometry}, checksum {options.checksum}). Ctrl-C ends it.')
    print(f'  create_node --ros-args -p port:={line.name}')
    if options.tcp and not re.match(r'127\.|::1$|localhost$', options.tcp[0]):
        print('Everybody who can reach this computer can drive it: there is no password.')
    if options.control:
        print(f'Lines on {options.control} change the world; try "help" first.')
    sys.stdout.flush()


def _serve(options: argparse.Namespace, guesses: Guesses, config: BodyConfig) -> None:
    body = Body(options.world, rounding=Rounding(options.odometry), seed=options.seed,
                config=config)
    create = Create(body, checksum=Checksum(options.checksum), guesses=guesses,
                    seed=options.seed)
    with ExitStack() as stack:
        line = _line(options)
        stack.callback(line.close)
        server = Server(create, line, Faults(options.fault, options.seed), speed=options.speed,
                        linger=options.linger)
        _end_on_signals(server)
        if options.control:
            server.control_port = ControlPort(options.control, server.control)
            stack.callback(server.control_port.close)
        if options.record:
            server.watchers.append(_recorder(server, options.record, stack))
        _announce(options, line)
        server.serve()


def say(text: str, path: Path) -> str:
    """Send a line to the control socket of a simulated robot; return its answer."""
    with socket.socket(socket.AF_UNIX) as robot, naming(path):
        robot.connect(str(path))
        robot.sendall(f'{text}\n'.encode())
        with robot.makefile() as answers:
            return answers.readline().strip()


def export(world: World, path: Path) -> str:
    """Write a world, and say what was written; OSError names a file that cannot be."""
    drawn, image = map_of(world), path.with_suffix('.pgm')
    files = {path: drawn.yaml(image.name, world.name).encode(), image: drawn.pgm()}
    for each in files:
        if each.exists():
            raise FileExistsError(
                errno.EEXIST, 'exists already; remove it, or give another name', str(each))
    for each, content in files.items():
        with naming(each):
            each.write_bytes(content)
    return f'{path} and {image}: a map for Nav2, {drawn.width} by {drawn.height} cells'


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_sim`; return its exit code. BrokenPipeError: nobody reads its output."""
    parser = _arguments()
    options = parser.parse_args(arguments)
    try:
        config, guesses = parse_guesses(options.guess)
        config = replace(config, gyro=config.gyro or options.gyro)
    except ValueError as error:
        parser.error(str(error))
    for name, value in vars(options).items() if options.replay else ():
        default = parser.get_default(name)
        if name not in REPLAY_HAS and value != default and getattr(value, 'name', '') != default:
            parser.error(f'--{name} does not work with --replay: nothing is simulated then')
    if options.say is not None and not options.control:
        parser.error('--say needs --control PATH: the socket that the robot has printed')
    try:
        if options.say is not None:
            answer = say(options.say, options.control)
            print(answer)
            return 0 if answer.startswith('ok') else 1
        if options.export:
            print(export(options.world, options.export))
        elif options.replay:
            play(options.replay, lambda: _line(options), options.speed, _end_on_signals)
        else:
            _serve(options, guesses, config)
    except BrokenPipeError:
        raise  # nobody reads the output: the caller ends the program quietly
    except (CaptureError, WorldError) as error:
        print(f'create_sim: {error}', file=sys.stderr)
        return 1
    except OSError as error:
        where = f'{error.filename}: ' if error.filename else ''
        print(f'create_sim: {where}{error.strerror or error}', file=sys.stderr)
        return 2
    return 0
