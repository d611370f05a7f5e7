# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Rules for imports: each room imports only what RULES allows, and no imports form a ring.

A room is a package or a module with a rule of its own. A pure room has no clock, no thread, no I/O
and no unseeded random numbers.
"""

from collections.abc import Iterable
from dataclasses import dataclass
import re
import sys

import pytest

from support.source import classes, docstring, imported, modules, PACKAGE, plain_calls


@dataclass(frozen=True)
class Rule:
    """What a room may import, besides itself and the standard library."""

    ours: tuple[str, ...] = ()
    """Other rooms of this package; '' is the package's own __init__."""
    others: str = '(?!)'
    """Pattern for names of other packages; the default matches none."""
    pure: bool = True
    """Whether it may not import IMPURE modules or make IMPURE_CALLS."""


MESSAGES = r'(builtin_interfaces|rcl_interfaces|std_srvs|\w+_msgs)\.(msg|srv|action)'
ROS = rf'rclpy|ament_index_python|{MESSAGES}'
BAGS = r'rosbags|mcap|zstandard'

# A module is in the room with the longest name here that is the module or a package around it.
RULES = {
    '': Rule(),
    'robot': Rule(),
    'oi': Rule(ours=('robot',)),
    'oi.__main__': Rule(ours=('oi.tools.command_line',), pure=False),
    'oi.tools': Rule(ours=('oi', 'robot')),
    'oi.tools.command_line': Rule(ours=('oi', 'oi.tools', 'robot'), pure=False),
    'odometry': Rule(ours=('robot',), others='numpy'),
    'driver': Rule(ours=('odometry', 'oi', 'oi.tools', 'robot')),
    'sim': Rule(),
    'sim.world': Rule(ours=('sim', 'robot')),
    'sim.body': Rule(ours=('sim', 'sim.world', 'oi', 'robot')),
    'sim.firmware': Rule(ours=('sim', 'sim.body', 'sim.world', 'oi', 'robot')),
    'sim.server': Rule(ours=('sim', 'sim.firmware', 'sim.body', 'sim.world', 'oi',
                             'oi.tools', 'robot'), pure=False),
    'link': Rule(ours=('driver', 'oi', 'oi.tools', 'robot'), others='serial', pure=False),
    'ros': Rule(ours=('ros.messages', 'ros.rotation', 'ros.serialized', 'link', 'driver',
                      'odometry', 'oi', 'oi.tools', 'robot', ''),
                others=rf'{ROS}|{BAGS}|yaml', pure=False),
    'ros.messages': Rule(ours=('ros.rotation', 'driver', 'odometry', 'oi', 'oi.tools', 'robot'),
                         others=MESSAGES),
    'ros.rotation': Rule(),
    'ros.serialized': Rule(),
    'pages': Rule(pure=False),
    'apps': Rule(ours=('ros', 'pages', 'ros.messages', 'ros.rotation', 'link',
                       'driver', 'odometry', 'oi', 'oi.tools', 'robot', ''),
                 others=rf'{ROS}|{BAGS}|numpy|yaml|aiohttp|segno', pure=False),
}
PROGRAMS = 'apps'
"""Each program in this package is a room of its own, under this rule."""
IMPURE = {
    'argparse', 'asyncio', 'concurrent', 'datetime', 'fcntl', 'glob', 'io', 'logging',
    'multiprocessing', 'os', 'pathlib', 'pty', 'queue', 'random', 'secrets', 'select',
    'selectors', 'shutil', 'signal', 'socket', 'subprocess', 'sys', 'tempfile', 'termios',
    'threading', 'time', 'tty', 'uuid',
}
SEEDABLE = 'random.Random'
IMPURE_CALLS = {'open(...)', 'print(...)', 'input(...)', 'Random()'}
MODULES = {name.removeprefix(PACKAGE).lstrip('.'): path
           for name, path in modules(PACKAGE).items()}
SAYS_PURE = re.compile(r'\bPure\b')
"""In the docstring of a module: it is pure, though its room may not be."""


def lies_in(name: str, room: str) -> bool:
    """Return whether a dotted name is a room or something in it."""
    return not room or f'{name}.'.startswith(f'{room}.')


def named_room(name: str) -> str:
    """Return the name in RULES under which a module of ours, or a name in it, falls."""
    return max((room for room in RULES if lies_in(name, room)), key=len)


def room_of(name: str) -> str:
    """Return the room that a module of ours, or a name in it, is in."""
    room = named_room(name)
    return '.'.join(name.split('.')[:2]) if room == PROGRAMS else room


def pure_parts() -> list[str]:
    """Return the modules that say that they are pure, in rooms that are not."""
    return [module for module, path in MODULES.items()
            if not RULES[named_room(module)].pure and SAYS_PURE.search(docstring(path))]


def may_import(module: str, name: str) -> bool:
    """Return whether the rules allow a module to import a name."""
    rule, (top, _, rest) = RULES[named_room(module)], name.partition('.')
    if top == PACKAGE:
        return room_of(rest) in (room_of(module), *rule.ours)
    if top in sys.stdlib_module_names:
        return not rule.pure or top not in IMPURE or name == SEEDABLE
    return bool(re.match(rf'({rule.others})\b', name))


def module_of(name: str) -> str | None:
    """Return the module of ours that an imported name is or is in; None for other packages."""
    inside = name.removeprefix(PACKAGE).lstrip('.')
    while inside not in MODULES and inside:
        inside = inside.rpartition('.')[0]
    return inside if name.startswith(PACKAGE) and inside else None


def imports() -> dict[str, set[str]]:
    """Return the graph of imports: for each module of ours, those that it imports."""
    found = {module: {module_of(name) for name in imported(path)} - {None, module}
             for module, path in MODULES.items()}
    return {module: {str(other) for other in others} for module, others in found.items()}


def at_depth(graph: dict[str, set[str]], depth: int) -> dict[str, set[str]]:
    """Return a graph of packages: names of modules are cut after `depth` parts."""
    folded: dict[str, set[str]] = {}
    for module, others in graph.items():
        name = '.'.join(module.split('.')[:depth])
        folded.setdefault(name, set()).update('.'.join(o.split('.')[:depth]) for o in others)
    return {name: others - {name} for name, others in folded.items()}


def ring(graph: dict[str, set[str]]) -> list[str]:
    """Return names that import each other in a ring, the first one twice; empty without one."""
    left = {name: set(others) for name, others in graph.items()}
    # A name that imports nothing that is left is in no ring.
    while ends := [name for name, others in left.items() if not others & left.keys()]:
        for name in ends:
            del left[name]
    if not left:
        return []
    path = [next(iter(left))]
    while path.count(path[-1]) == 1:
        path.append(next(other for other in sorted(left[path[-1]]) if other in left))
    return path[path.index(path[-1]):]


def rooms_named(rules: Iterable[Rule]) -> set[str]:
    """Return all rooms that the rules name."""
    return {room for rule in rules for room in rule.ours} | set(RULES) | {PROGRAMS}


@pytest.mark.parametrize('module', MODULES)
def test_imports_only_what_its_room_allows(module: str) -> None:
    wrong = [name for name in imported(MODULES[module]) if not may_import(module, name)]
    assert not wrong, f'{module} may not import {wrong}: see RULES'


@pytest.mark.parametrize('module', [
    module for module in MODULES if RULES[named_room(module)].pure])
def test_a_pure_room_makes_no_impure_calls(module: str) -> None:
    assert not IMPURE_CALLS & set(plain_calls(MODULES[module]))


@pytest.mark.parametrize('module', pure_parts())
def test_a_module_that_says_so_is_pure(module: str) -> None:
    tops = {name.partition('.')[0] for name in imported(MODULES[module])}
    assert not tops & (IMPURE | {'rclpy', 'aiohttp'})
    assert not IMPURE_CALLS & set(plain_calls(MODULES[module]))


def test_modules_that_say_so_are_found() -> None:
    assert {'apps.web.driver_seat', 'ros.rotation'} - set(pure_parts()) == {
        'ros.rotation'}, 'the last one has a rule of its own'


@pytest.mark.parametrize('depth', [1, 2, 3, 4])
def test_nothing_imports_itself_in_a_ring(depth: int) -> None:
    assert not ring(at_depth(imports(), depth))


def test_a_ring_is_found() -> None:
    graph = {'a': {'b'}, 'b': {'c', 'd'}, 'c': {'a'}, 'd': set[str]()}
    assert sorted(ring(graph)[:-1]) == ['a', 'b', 'c']
    assert not ring({'a': {'b', 'c'}, 'b': {'c'}, 'c': set[str]()})


def test_every_rule_names_what_exists() -> None:
    assert not rooms_named(RULES.values()) - set(MODULES)


def test_the_rules_form_no_ring() -> None:
    assert not ring({room: set(rule.ours) for room, rule in RULES.items()})


def test_no_rule_admits_every_package() -> None:
    assert not [room for room, rule in RULES.items() if re.match(rule.others, 'a_stranger')]


def test_no_two_files_have_one_name() -> None:
    names = [path.stem for path in MODULES.values() if not path.stem.startswith('__')]
    assert not {name for name in names if names.count(name) > 1}


def test_no_two_classes_have_one_name() -> None:
    places: dict[str, list[str]] = {}
    for module, path in MODULES.items():
        for name in classes(path):
            places.setdefault(name, []).append(module)
    doubled = {name: found for name, found in places.items() if len(found) > 1}
    assert not doubled, f'choose another name for all but one: {doubled}'


@pytest.mark.parametrize(('module', 'name'), [
    ('oi.codes', 'time'), ('oi.codes', 'create_oi_ros.odometry'), ('oi', 'serial'),
    ('oi.codes', 'create_oi_ros.oi.tools.text'), ('oi.tools.text', 'sys'),
    ('sim.body.body', 'create_oi_ros.sim.server.lines'),
    ('sim.world.world', 'create_oi_ros.sim.body'),
    ('driver.machine', 'random.random'), ('driver', 'create_oi_ros.sim.body'),
    ('sim.body.body', 'create_oi_ros.driver'), ('sim.body.body', 'os.path'),
    ('sim.server', 'create_oi_ros.link.port'), ('link.port', 'create_oi_ros.ros'),
    ('ros.messages', 'rclpy.node'), ('ros.serialized', 'rclpy.serialization'),
    ('ros.node', 'create_oi_ros.sim.server'),
    ('apps.demo.tour', 'create_oi_ros.apps.run'), ('apps.run', 'create_oi_ros.sim'),
    ('robot', 'create_oi_ros.oi'),
])
def test_rules_refuse(module: str, name: str) -> None:
    assert not may_import(module, name)
