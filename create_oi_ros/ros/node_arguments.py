# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The command line of `create_node`: ROS arguments, and help with everything else."""

from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Sequence
from dataclasses import fields
import textwrap

from rclpy.utilities import remove_ros_args

from .. import __version__
from .parameters import allowed, Parameters, shown, suggestion

WIDTH = 96
ROS_FLAGS = ('-p', '--param', '-r', '--remap', '--params-file', '--log-level')
"""Arguments that ROS knows, after --ros-args."""


def parse(arguments: Sequence[str]) -> None:
    """Answer --help and --version, and refuse what is no ROS argument, with exit code 2."""
    remove_ros_args(['', *arguments])  # raises an error if ROS cannot read its own arguments
    plain, _ = split(arguments)
    if not plain:
        return
    parser = ArgumentParser(
        prog='create_node', formatter_class=RawDescriptionHelpFormatter,
        usage='create_node [--help] [--version] [--ros-args -p NAME:=VALUE ...]',
        description='Run the driver of an iRobot Create as a ROS 2 node.',
        epilog=parameter_help())
    parser.add_argument('--version', action='version', version=f'create_node {__version__}')
    _, unknown = parser.parse_known_args(plain)
    if unknown:
        parser.error(refusal(unknown))


def split(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the plain arguments, and those that stand between --ros-args and --."""
    plain: list[str] = []
    ros: list[str] = []
    of_ros = False
    for argument in arguments:
        if argument in ('--ros-args', '--'):
            of_ros = argument == '--ros-args'
        else:
            (ros if of_ros else plain).append(argument)
    return plain, ros


def names_only(ros: Sequence[str]) -> list[str]:
    """Return those ROS arguments of a driver that its partners need: namespace and topics."""
    return [part for flag, rule in zip(ros, ros[1:])
            if flag in ('-r', '--remap') and not rule.startswith(('__node:', '__name:'))
            for part in (flag, rule)]


def parameter_help() -> str:
    """Return all parameters with defaults, as help text."""
    lines = ['parameters (give them as --ros-args -p NAME:=VALUE, or --params-file FILE):']
    for declared in fields(Parameters):
        facts = declared.metadata
        text = f'{facts["description"]}. '
        if values := allowed(facts):
            text += f'{"One of " if facts["choices"] else ""}{values}.'
        lines.append(f'  {declared.name}:={shown(declared.default)}')
        lines += textwrap.wrap(text, WIDTH, initial_indent=' ' * 6, subsequent_indent=' ' * 6)
    return '\n'.join(lines)


def refusal(unknown: Sequence[str], options: Sequence[str] = ('--help', '--version')) -> str:
    """Say that an argument is none of the program's options, and how to write what is meant."""
    first = unknown[0]
    if first in ROS_FLAGS or ':=' in first:
        flag = '' if first in ROS_FLAGS else '-p '
        return f'{first} is for ROS: write --ros-args {flag}{" ".join(unknown)}'
    option, _, value = first.partition('=')
    name = option.lstrip('-').replace('-', '_')
    known = {declared.name: f'--ros-args -p {declared.name}:=VALUE'
             for declared in fields(Parameters)}
    if name in known:
        value = value or (unknown[1] if len(unknown) > 1 else 'VALUE')
        return f'{first} is a parameter: write --ros-args -p {name}:={value}'
    known |= {each.lstrip('-').replace('-', '_'): each for each in options}
    return f'unknown argument {first}{suggestion(name, known)}'
