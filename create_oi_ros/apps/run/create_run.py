# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_run`: a robot, its node and its web page, with a status line every second.

Without `--port` the robot is a simulated one on a pseudo terminal. The page is for this computer
only, without `--host`. What follows `--ros-args` is for the node.
"""

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
import os
from pathlib import Path
from shlex import quote
import shutil
import sys

from create_oi_msgs.msg import Bumper, Mode
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.task import Future
from sensor_msgs.msg import BatteryState

from ...ros.node_arguments import names_only, refusal, split
from ...ros.process import call_on_signal, Children, ros_executor, spin_until
from ...ros.programs import check_environment
from ...ros.simulated_run import run_domain, run_folder
from ...ros.waiting import announce
from ...sim.world_files import read_world, shipped_names, WorldError
from .status import RobotStatus, show, status_line

WORLD = 'apartment'
"""World of the simulated robot, if nothing else is asked for."""


class StatusNode(Node):
    """Subscribes to the driver's topics and shows a status line every second."""

    def __init__(self, children: Children, ended: Future) -> None:
        """Watch the children too: when one ends by itself, `ended` gets exit code 1."""
        super().__init__('create_run')
        self._ended = ended
        self._children = children
        self._status = RobotStatus()
        self._status.listen(self, Odometry, Mode, BatteryState, Bumper, DiagnosticArray)
        self.create_timer(1.0, self._show)

    def _show(self) -> None:
        ended = self._children.ended()
        if ended is not None:
            print(f'create_run: {ended}; see above for why', file=sys.stderr)
            self._ended.set_result(1)
            return
        show(self._status.line())


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
    return '\n'.join([
        *lines, 'Or see and drive it in a browser, at the address that is printed below.',
        'Ctrl-C stops the robot and everything here.'])


def _watch(children: Children, ended: Future, names: list[str], driver: str) -> int:
    with (ros_executor(['--ros-args', *names]) as executor,
          announce(int(os.environ.get('ROS_DOMAIN_ID') or 0), driver)):
        executor.add_node(StatusNode(children, ended))
        try:
            spin_until(executor, ended)
        finally:
            # Before ROS shuts down: the robot may be moving.
            children.end()
    return int(ended.result())


def world(text: str) -> str:
    """Return the name or file of a world; ArgumentTypeError says what is wrong with it."""
    try:
        if text:  # '' is refused below, as that of other arguments
            read_world(text)
    except WorldError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


def _arguments(given: Sequence[str]) -> argparse.Namespace:
    """Return the arguments; those that contradict each other end the program."""
    parser = argparse.ArgumentParser(
        prog='create_run', description=__doc__,
        usage='create_run [--port PORT | --world WORLD] [--lidar] [--gyro] [--capture FILE]\n'
              '                  [--host HOST] [--token-file FILE]\n'
              '                  [--ros-args -p NAME:=VALUE --params-file FILE -r FROM:=TO ...]',
        epilog='create_node --help lists the parameters')
    parser.add_argument('--port', help='serial device of a real robot; default: a simulated one')
    parser.add_argument('--world', metavar='NAME|FILE', type=world, help=(
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
        '0.0.0.0: also for telephones in your network, with a token'))
    parser.add_argument('--token-file', metavar='FILE', help=(
        'keep the token of the web page in FILE, so that it lasts'))
    plain, ros = split(given)
    options, unknown = parser.parse_known_args(plain)
    if unknown:
        parser.error(refusal(unknown))
    for name, value in vars(options).items():
        if value == '':
            parser.error(f'--{name.replace("_", "-")} is empty: give a value, or leave it out')
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
        children.start('create_sim', '--link', port, '--world', options.world or WORLD,
                       '--control', control, *(['--gyro'] if options.gyro else []))
        page += ['--control', control]
        if options.lidar:
            children.start('create_lidar', '--control', control, '--ros-args',
                           *names_only(options.ros))
    children.start('create_web', *page, '--ros-args', *names_only(options.ros))
    capture = ['-p', f'capture:={quoted(options.capture)}'] if options.capture else []
    gyro = ['-p', 'gyro:=analog'] if options.gyro else []
    children.start('create_node', '--ros-args', *gyro, *options.ros, '-p', f'port:={quoted(port)}',
                   *capture)


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
        port = options.port or f'{stack.enter_context(run_folder())}/create'
        if options.port is None:
            stack.enter_context(run_domain())
        print(introduction(port, options.port is None, namespace), flush=True)
        stack.callback(children.end)
        stack.enter_context(status_line())
        _start(children, port, options)
        return _watch(children, ended, names, f'{namespace}/create')
