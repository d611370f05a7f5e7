# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_fleet`: the drivers of several robots in one process, each in a namespace of its own."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, ExitStack, nullcontext
import os
import re
from shlex import quote
import sys
from typing import NamedTuple

from rclpy.task import Future
from rclpy.utilities import remove_ros_args

from ..ros.node import CreateNode, run
from ..ros.process import Children
from ..ros.simulated_run import run_domain, run_folder

NAME = re.compile(r'[A-Za-z]\w*', re.ASCII)
EXAMPLE = 'robot1=/dev/ttyUSB0'
MOST = 20
"""Simulated robots at most: each takes a twentieth of a core."""


class Member(NamedTuple):
    """A robot: its namespace, and its serial device or pyserial URL."""

    name: str
    port: str


def member(text: str) -> Member:
    """Return the robot of an argument NAME=PORT; ArgumentTypeError says what is wrong with it."""
    name, _, port = text.partition('=')
    if not port:
        raise ArgumentTypeError(f'{text!r} has no port: write NAME=PORT, such as {EXAMPLE}')
    if not NAME.fullmatch(name):
        raise ArgumentTypeError(
            f'{name!r} cannot be a namespace: allowed are letters, digits and _, a letter first')
    return Member(name, port)


def _arguments() -> ArgumentParser:
    parser = ArgumentParser(
        prog='create_fleet',
        usage='create_fleet [--help] NAME=PORT ... | --simulated COUNT [--ros-args ...]',
        description='Run the drivers of several robots in one process. Each robot has a '
        'namespace, /NAME, and the frames NAME/odom and NAME/base_footprint. This takes less '
        'memory than a create_node for each robot, but when it ends or crashes, all robots stop.',
        epilog='What follows --ros-args holds for all robots. A --params-file may have a part '
        'for each: "/robot1/create:" in the place of "/**:".')
    parser.add_argument('members', metavar='NAME=PORT', nargs='*', type=member,
                        help=f'a robot, such as {EXAMPLE}')
    parser.add_argument('--simulated', metavar='COUNT', type=_count,
                        help=f'simulate so many robots: robot1, robot2, ...; 1 to {MOST}')
    return parser


def _count(text: str) -> int:
    count = int(text) if text.isdecimal() else 0
    if not 1 <= count <= MOST:
        raise ArgumentTypeError(f'{text!r}; allowed: 1 to {MOST} robots')
    return count


def parse(arguments: Sequence[str]) -> Namespace:
    """Return the robots, or how many to simulate; refuse what is wrong, with exit code 2."""
    parser = _arguments()
    options = parser.parse_args(remove_ros_args(['create_fleet', *arguments])[1:])
    if bool(options.members) == bool(options.simulated):
        parser.error('give NAME=PORT for each robot, or --simulated COUNT')
    for what, values in zip(Member._fields, zip(*options.members)):
        value, count = Counter(values).most_common(1)[0]
        if count > 1:
            parser.error(f'{count} robots have the {what} {value}: each needs its own')
    return options


@contextmanager
def simulated(count: int) -> Iterator[list[Member]]:
    """Yield so many simulated robots, in a ROS domain that no other run has; end them after."""
    with ExitStack() as stack:
        folder, domain = stack.enter_context(run_folder()), stack.enter_context(run_domain())
        children = Children()
        stack.callback(children.end)
        robots = [Member(f'robot{number}', f'{folder}/robot{number}')
                  for number in range(1, count + 1)]
        for robot in robots:
            children.start('create_sim', '--link', robot.port, '--world', 'room')
        environment = os.environ.get('CREATE_OI_ENV')
        join = [f'source {quote(environment)}'] if environment else []
        print('In another shell, join them:\n'
              f'    {" && ".join([*join, f"export ROS_DOMAIN_ID={domain}"])}', flush=True)
        yield robots


def driver(robot: Member, ended: Future) -> CreateNode:
    """Return the driver of a robot; ValueError says which parameter is wrong."""
    # These stand before what was given for all robots.
    given = {'port': robot.port, 'odom_frame': f'{robot.name}/odom',
             'base_frame': f'{robot.name}/base_footprint'}
    parameters = [part for name, value in given.items() for part in ('-p', f'{name}:={value}')]
    return CreateNode(
        ended, cli_args=['--ros-args', '-r', f'__ns:=/{robot.name}', *parameters])


def main() -> int:
    """Run all drivers until they are told to stop; 0 when they were, 2: an argument is wrong."""
    options = parse(sys.argv[1:])
    robots = simulated(options.simulated) if options.simulated else nullcontext(options.members)
    with robots as members:
        return run('create_fleet', lambda ended: [driver(each, ended) for each in members])
