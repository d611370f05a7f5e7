# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Reads documentation pages: fenced blocks, and the names in `ros2` commands."""

from dataclasses import dataclass
from pathlib import Path
import re
import shlex
from typing import Any

from create_oi_msgs import action as our_actions
from create_oi_msgs import msg as our_messages
from geometry_msgs.msg import Twist, TwistStamped
import yaml

from create_oi_ros.ros.actions import ALL_ACTIONS
from create_oi_ros.ros.parameters import Parameters
from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.ros.services import SERVICES
from create_oi_ros.ros.topics import ALL_TOPICS

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r'(?:^<!-- ([^\n]*?) -->\n)?^```(\w*)\n(.*?)^```$', re.M | re.S)
OURS = {f'/{topic.name.lstrip("/")}' for topic in ALL_TOPICS} | {'/cmd_vel'}
"""Full names of all topics of a driver without a namespace."""
ACTION_TYPES = {f'/{action.name}': action.type for action in ALL_ACTIONS}
SERVICE_TYPES = {f'/{service.name}': service.type for service in SERVICES}
LAUNCH = re.compile(r"^    '(\w+)': \(|DeclareLaunchArgument\('(\w+)'", re.M)
"""How the launch files declare their arguments."""


@dataclass(frozen=True)
class Block:
    """One fenced block: the comment just before it, its language, its text."""

    mark: str
    language: str
    text: str


def blocks(path: Path) -> list[Block]:
    """Return the fenced blocks of a page, in order."""
    return [Block(*found) for found in BLOCK.findall(path.read_text('utf-8'))]


def commands(text: str) -> list[list[str]]:
    """Return the commands of a block as words; a backslash continues a line."""
    lines = text.replace('\\\n', ' ').splitlines()
    return [shlex.split(line, comments=True) for line in lines if line and line[0] != '#']


def type_name(kind: Any) -> str:
    """Return a type's name as `ros2` writes it."""
    package, folder, _ = kind.__module__.split('.', 2)
    return f'{package}/{folder}/{kind.__name__}'


def check_ros2(words: list[str], foreign: frozenset[str] = frozenset()) -> None:
    """
    Check that every name in a `ros2` command exists here or is in `foreign`.

    `foreign` holds packages and topics of others.
    """
    assert words[0] == 'ros2', words
    match words[1:]:
        case ['topic', 'list']:
            pass
        case ['topic', 'echo' | 'hz' | 'info', *rest]:
            assert [word for word in rest if not word.startswith('-')][0] in OURS | foreign
        case ['topic', 'pub', '--rate', _, '/cmd_vel', kind, fields]:
            made = {type_name(each): each for each in (Twist, TwistStamped)}[kind]
            check_fields(made, yaml.safe_load(fields))
        case ['service', 'call', name, kind, *fields]:
            assert kind == type_name(SERVICE_TYPES[name])
            check_fields(SERVICE_TYPES[name].Request, yaml.safe_load(' '.join(fields) or '{}'))
        case ['action', 'list']:
            pass
        case ['action', 'send_goal', *rest]:
            name, kind, fields = (word for word in rest if word != '--feedback')
            assert kind == type_name(ACTION_TYPES[name])
            check_fields(ACTION_TYPES[name].Goal, yaml.safe_load(fields))
        case ['interface', 'show', name]:
            kind = name.removeprefix('create_oi_msgs/msg/').removeprefix('create_oi_msgs/action/')
            assert hasattr(our_messages, kind) or hasattr(our_actions, kind)
        case ['run', 'create_oi_ros', program, *arguments]:
            assert program in PROGRAMS
            check_parameters(arguments)
        case ['launch', 'create_oi_ros', file, *arguments]:
            declared = LAUNCH.findall((ROOT / 'launch' / file).read_text('utf-8'))
            assert {word.partition(':=')[0] for word in arguments} <= set().union(*declared)
        case ['param', 'set', '/create', name, _]:
            assert name in Parameters.__dataclass_fields__
        case ['run' | 'launch', package, *_]:
            assert package in foreign, f'{package} is neither ours nor declared'
        case ['bag', 'record' | 'play', *_]:
            pass
        case _:
            raise AssertionError(f'no check for {words}')


def check_parameters(arguments: list[str]) -> None:
    """Check that `-p NAME:=VALUE` names parameters of the node."""
    for before, word in zip(arguments, arguments[1:]):
        if before == '-p':
            assert word.partition(':=')[0] in Parameters.__dataclass_fields__


def check_fields(kind: Any, values: dict[str, Any]) -> None:
    """Check that a message has these fields, nested ones too."""
    made = kind()
    for name, value in values.items():
        assert name in kind.get_fields_and_field_types(), f'{kind.__name__} has no {name}'
        if isinstance(value, dict):
            check_fields(type(getattr(made, name)), value)
