# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_run`: a robot, its node and its web page, with a status line every second.

Without `--port` the robot is a simulated one on a pseudo terminal. The page is for this computer
only, without `--host`. What follows `--ros-args` is for the node.
"""

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, ExitStack
from math import degrees, inf, isnan, nan
import os
from pathlib import Path
import re
from shlex import quote
import shutil
import socket
from subprocess import DEVNULL
import sys
from tempfile import TemporaryDirectory
import time
from typing import Any

from create_oi_msgs.msg import Mode
import rclpy
from rclpy.task import Future

from ..ros.collector import Collector, level_of, subscribe
from ..ros.diagnostics import ERROR, LINK
from ..ros.messages import mode_name, yaw_of
from ..ros.node_arguments import names_only, refusal, split
from ..ros.process import call_on_signal, Children, ros_executor, spin_until
from ..ros.programs import check_environment, UserError
from ..ros.waiting import announce, drivers
from ..sim.world_files import read_world, shipped_names, WorldError

WORLD = 'apartment'
"""World of the simulated robot, if nothing else is asked for."""
SHOWN = ('odom', 'mode', 'battery_state', 'bumper', 'diagnostics')
"""Topics of which the status line is made."""
COMPLAINTS = ('driver', LINK, 'battery')
"""Statuses of the driver that the line has when they are not well."""
MOST_EVENTS = 100
"""Events of a kind that are kept; a line shows those of a second."""
WIDTH = 80
"""Columns of the status line at most, where there is no terminal."""
CLEAR = '\r\x1b[K'
"""Go to the begin of the line, and clear it."""
LOG_FORMAT = 'RCUTILS_CONSOLE_OUTPUT_FORMAT'
USUAL_FORMAT = '[{severity}] [{time}] [{name}]: {message}'
DOMAINS = range(215, 233)
"""Few people choose these; their UDP ports lie above those that Linux gives to other programs."""


class RobotStatus:
    """Puts what the driver publishes into one line."""

    def __init__(self, namespace: str = '') -> None:
        """Take the messages of the driver in this namespace."""
        self._collector = Collector(namespace, MOST_EVENTS)
        self._frames = 0
        self._line_at = -inf
        """When the last line was."""

    def take(self, name: str, time: float, message: Any) -> None:
        """Take a message of a topic, at a time in seconds."""
        self._collector.take(name, time, message)
        self._frames += name == 'odom'

    def _no_robot(self) -> str:
        """Return why no robot answers, as far as the driver knows."""
        link = self._collector.newest.get('diagnostics', {}).get(LINK)
        if link is None or link.level != ERROR:
            return ''
        # A port may have a long name, and nobody has two here.
        port = self._collector.link.get('port')
        return str(link.message.replace(port, 'port', 1) if port else link.message)

    def line(self, now: float, width: int = WIDTH) -> str:
        """Return the line, and begin the next second; the pose of a robot is always in it."""
        motion, mode = self._motion(), self._collector.newest.get('mode')
        name = 'no node yet' if mode is None else f'{mode_name(mode.mode, mode.reason):7s}'
        # Parts of the motion that are the pose.
        pose = 0 if mode is not None and mode.mode == Mode.UNKNOWN else 2
        said = (*motion[:pose], *self._remarks(width))
        line = '  '.join((f'{self._frames:2d} frames/s', name, *said))
        if len(line) > width:
            line = '  '.join((name.rstrip(), *said))
        if len(line) > width:
            line = f'{line[:width - 3]}...'
        for text in motion[pose:]:
            if len(line) + 2 + len(text) > width:
                break
            line += f'  {text}'
        self._frames, self._line_at = 0, now
        return line.rstrip()

    def _remarks(self, width: int) -> list[str]:
        """Return what is unusual, the most important first."""
        sides = {side for span in self._collector.spans['bumper'].all
                 if span.end >= self._line_at for side in span.text.split(' and ')}
        remarks = [f'BUMP {" and ".join(sorted(sides))}'] if sides else []
        newest = self._collector.newest
        mode, statuses = newest.get('mode'), newest.get('diagnostics', {})
        if mode is not None and mode.reason:
            unknown = mode.mode == Mode.UNKNOWN
            remarks.append((self._no_robot() if unknown else '') or mode.reason)
        # No robot answers: all else follows from that.
        elif mode is not None:
            remarks += [gist(statuses[about].message, width // 2) for about in COMPLAINTS
                        if about in statuses and level_of(statuses[about])]
        return remarks

    def _motion(self) -> list[str]:
        newest = self._collector.newest
        odom, battery = newest.get('odom'), newest.get('battery_state')
        if odom is None:
            return []
        pose, twist = odom.pose.pose, odom.twist.twist
        charge = nan if battery is None else battery.percentage
        charged = '' if isnan(charge) else f'{charge:.0%}'
        return [f'x {pose.position.x:+.2f} y {pose.position.y:+.2f} m',
                f'{degrees(yaw_of(pose.orientation)):+4.0f} deg', charged,
                f'{twist.linear.x:+.2f} m/s', f'{twist.angular.z:+.2f} rad/s']


def gist(message: str, width: int) -> str:
    """Return a long message without its advice: the first clause, and what brackets add to it."""
    if len(message) <= width:
        return message
    added = re.search(r' \([^()]*\)$', message)
    return message.partition(', ')[0] + (added[0] if added else '')


def on_terminal() -> bool:
    """Return whether the line can be updated in place."""
    return sys.stdout.isatty() and os.environ.get('TERM', 'dumb') != 'dumb'


@contextmanager
def status_line() -> Iterator[None]:
    """Keep the log lines of children apart from a status line that is updated in place."""
    if not on_terminal():
        yield
        return
    # A log line begins by clearing the status line, which is shown again below it.
    os.environ[LOG_FORMAT] = CLEAR + os.environ.get(LOG_FORMAT, USUAL_FORMAT)
    try:
        yield
    finally:
        print(flush=True)


def show(line: str) -> None:
    """Show the line: in place on a terminal, as a line of its own elsewhere."""
    if on_terminal():
        print(f'{CLEAR}{line}', end='\r', flush=True)
    else:
        print(line, flush=True)


def introduction(port: str, simulated: bool, namespace: str = '') -> str:
    """Return what runs and what to try next, with commands that work on this machine."""
    join = f' --ros-args -r __ns:={quote(namespace)}' if namespace else ''
    robot = 'a simulated Create' if simulated else 'the robot'
    domain, environment = os.environ.get('ROS_DOMAIN_ID'), os.environ.get('CREATE_OI_ENV')
    lines = [f'create_run starts node {namespace}/create for {robot} on {port}, '
             f'ROS domain {domain or 0}.']
    joining = [f'source {quote(environment)}'] if environment else []
    joining += [f'export ROS_DOMAIN_ID={domain}'] if domain else []
    if joining:
        lines += ['In another shell, join it:', f'    {" && ".join(joining)}']
    if environment:
        example = quote(str(Path(environment).parent / 'examples' / 'drive.py'))
        lines += ['then drive it and watch its odometry:', f'    python {example}{join}']
    if shutil.which('ros2') is not None:
        lines += ['Watch a topic:', f'    ros2 topic echo {namespace}/bumper']
    if simulated:
        lines += ['Change its world; `help` lists how:',
                  f'    {"" if environment else "ros2 run create_oi_ros "}create_sim --control '
                  f'{port}.control --say "bump left 0.5"']
    return '\n'.join([
        *lines, 'Or see and drive it in a browser, at the address that is printed below.',
        'Ctrl-C stops the robot and everything here.'])


def _watch(children: Children, ended: Future, names: list[str]) -> int:
    """Show the status every second; return the exit code, 1 when a child has ended by itself."""
    def look() -> None:
        why = children.ended()
        if why is None:
            columns = shutil.get_terminal_size((WIDTH + 1, 0)).columns
            show(status.line(time.monotonic(), columns - 1))
        else:
            print(f'create_run: {why}; see above for why', file=sys.stderr)
            ended.set_result(1)
    with ros_executor(['--ros-args', *names]) as executor:
        node = rclpy.create_node('create_run')
        status = RobotStatus(node.get_namespace())
        subscribe(node, SHOWN, lambda name, message: status.take(
            name, time.monotonic(), message))
        node.create_timer(1.0, look)
        executor.add_node(node)
        try:
            spin_until(executor, ended)
        finally:
            # Before ROS shuts down: the robot may be moving.
            children.end()
    return int(ended.result())


@contextmanager
def run_domain() -> Iterator[str]:
    """
    Yield the ROS domain of a simulated run: ROS_DOMAIN_ID, or else one that no other run has.

    In a domain of our own we also stay on this computer: another one may use the same number.
    UserError: all are taken.
    """
    given = os.environ.get('ROS_DOMAIN_ID')
    if given:
        yield given
        return
    for domain in DOMAINS:
        # The kernel frees an abstract name when the process ends, however it ends.
        with socket.socket(socket.AF_UNIX) as reservation:
            try:
                reservation.bind(f'\0create_oi_ros/domain/{domain}')
            except OSError:
                continue  # another run has it
            os.environ['ROS_DOMAIN_ID'] = str(domain)
            os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
            yield str(domain)
            return
    raise UserError(
        f'the ROS domains {DOMAINS[0]} to {DOMAINS[-1]}, which simulated runs take, are all in '
        'use: end a run, or choose a domain yourself with ROS_DOMAIN_ID')


def _arguments(given: Sequence[str]) -> argparse.Namespace:
    """Return the arguments; those that contradict each other end the program."""
    parser = argparse.ArgumentParser(
        prog='create_run', description=__doc__,
        usage='create_run [--port PORT | --world WORLD] [--lidar] [--gyro] [--capture FILE]\n'
              '                  [--host HOST] [--token-file FILE]\n'
              '                  [--ros-args -p NAME:=VALUE --params-file FILE -r FROM:=TO ...]',
        epilog='create_node --help lists the parameters')
    parser.add_argument('--port', help='serial device of a real robot; default: a simulated one')
    parser.add_argument('--world', metavar='NAME|FILE', help=(
        f'world of the simulated robot: {", ".join(shipped_names())}, or a file '
        f'(default: {WORLD})'))
    parser.add_argument('--lidar', action='store_true', help=(
        'give the simulated robot a lidar: scan, for SLAM and Nav2'))
    parser.add_argument('--gyro', action='store_true', help=(
        'a gyro is on the analog input of the cargo bay; a simulated robot gets one'))
    parser.add_argument('--capture', metavar='FILE', help=(
        'write every byte of the serial line to FILE, to be sent with a bug report'))
    parser.add_argument('--host', help=(
        'address on which the web page is served (default: 127.0.0.1, this computer only); '
        '0.0.0.0: also for phones in your network, with a token'))
    parser.add_argument('--token-file', metavar='FILE', help=(
        'keep the token of the web page in FILE, so that it lasts'))
    plain, ros = split(given)
    options, unknown = parser.parse_known_args(plain)
    if unknown:
        parser.error(refusal(unknown, [
            f'--{name.replace("_", "-")}' for name in vars(options)]))
    for name, value in vars(options).items():
        if value == '':
            parser.error(f'--{name.replace("_", "-")} is empty: give a value, or leave it out')
    try:
        read_world(options.world or WORLD)
    except WorldError as error:
        parser.error(f'argument --world: {error}')
    if options.port is not None and options.world is not None:
        parser.error('--port is for a real robot and --world for a simulated one: give one of '
                     'them')
    if options.port is not None and options.lidar:
        parser.error('--lidar is for a simulated robot: a real one has its own driver for it')
    if any(rule.startswith('port:=') for rule in ros):
        parser.error('port is no parameter here: write --port')
    options.ros = ros
    return options


def _start(children: Children, port: str, options: argparse.Namespace) -> None:
    page = [] if options.host is None else ['--host', options.host]
    page += [] if options.token_file is None else ['--token-file', options.token_file]
    if options.port is None:
        control = f'{port}.control'
        # What it prints is for those who start a driver by hand.
        children.start('create_sim', '--link', port, '--world', options.world or WORLD,
                       '--control', control, *(['--gyro'] if options.gyro else []),
                       stdout=DEVNULL)
        page += ['--control', control]
        if options.lidar:
            children.start('create_lidar', '--control', control, '--ros-args',
                           *names_only(options.ros))
    children.start('create_web', *page, '--ros-args', *names_only(options.ros))
    capture = ['-p', f'capture:={quoted(options.capture)}'] if options.capture else []
    gyro = ['-p', 'gyro:=analog'] if options.gyro else []
    children.start('create_node', '--ros-args', *gyro, *options.ros, '-p', f'port:={quoted(port)}',
                   *capture)


def refuse_second(domain: int, name: str) -> None:
    """UserError: a driver of this name runs in this ROS domain; both would obey each command."""
    if any((each.domain, each.name) == (domain, name) for each in drivers()):
        raise UserError(
            f'{name} runs already in ROS domain {domain} on this computer, and two drivers there '
            'would follow the same cmd_vel: end the other one, or start this one in a shell '
            'without ROS_DOMAIN_ID (`unset ROS_DOMAIN_ID`), in another domain, or in a namespace '
            '(--ros-args -r __ns:=/robot2)')


def quoted(text: str) -> str:
    """Return a text as YAML that stays a text, even if it looks like a number or a list."""
    return "'" + text.replace("'", "''") + "'"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until Ctrl-C; the exit code is 1 when a child ended by itself."""
    options = _arguments(sys.argv[1:] if arguments is None else arguments)
    names = names_only(options.ros)
    namespace = next((rule[len('__ns:='):].rstrip('/') for rule in names
                      if rule.startswith('__ns:=')), '')
    check_environment()
    children, ended = Children(), Future()
    call_on_signal(lambda: ended.set_result(0))
    with ExitStack() as stack:
        port = options.port
        if port is None:
            port = f'{stack.enter_context(TemporaryDirectory(prefix="create-"))}/create'
            stack.enter_context(run_domain())
        driver = int(os.environ.get('ROS_DOMAIN_ID') or 0), f'{namespace}/create'
        refuse_second(*driver)
        stack.enter_context(announce(*driver))
        print(introduction(port, options.port is None, namespace), flush=True)
        stack.callback(children.end)
        stack.enter_context(status_line())
        _start(children, port, options)
        return _watch(children, ended, names)
