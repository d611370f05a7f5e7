"""Imports run one way, form no ring, and the pure rooms have no clock, no thread and no I/O."""

from collections.abc import Iterable
from dataclasses import dataclass
import re
import sys

import pytest

from support.source import imported, modules, PACKAGE, plain_calls


@dataclass(frozen=True)
class Rule:
    """What a room may import besides itself and the standard library, and whether it is pure."""

    ours: tuple[str, ...] = ()
    """Rooms or modules of this package."""
    others: str = '(?!)'
    """Pattern of other packages' names; the default matches nothing."""
    pure: bool = True


MESSAGES = r'(builtin_interfaces|rcl_interfaces|std_srvs|\w+_msgs)\.(msg|srv|action)'
ROS = rf'rclpy|ament_index_python|{MESSAGES}'
BAGS = r'rosbags|mcap|zstandard'
SIMULATOR = ('oi', 'robot')

# A module falls under the longest name here that it is or lies in.
RULES = {
    '': Rule(),
    'robot': Rule(),
    'oi': Rule(ours=('robot',)),
    'oi.__main__': Rule(pure=False),
    'oi.tools.command_line': Rule(pure=False),
    'odometry': Rule(ours=('robot',), others='numpy'),
    'driver': Rule(ours=('oi', 'odometry', 'robot')),
    'sim': Rule(ours=SIMULATOR),
    'sim.server': Rule(ours=SIMULATOR, pure=False),
    'link': Rule(ours=('driver', 'oi', 'robot'), others='serial', pure=False),
    'ros': Rule(ours=('link', 'driver', 'odometry', 'oi', 'robot', '__version__'),
                others=rf'{ROS}|{BAGS}', pure=False),
    'ros.messages': Rule(ours=('driver', 'odometry', 'oi', 'robot'), others=MESSAGES),
    'ros.rotation': Rule(),
    'apps': Rule(ours=('ros', 'link', 'driver', 'odometry', 'oi', 'robot'),
                 others=rf'{ROS}|{BAGS}|matplotlib', pure=False),
}
PROGRAMS = 'apps'
"""In this room, each program is a room of its own: none may import another."""
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


def lies_in(name: str, room: str) -> bool:
    """Whether a dotted name is a room or something in it."""
    return not room or f'{name}.'.startswith(f'{room}.')


def rule_of(module: str) -> Rule:
    """Return the rule that a module falls under."""
    return RULES[max((room for room in RULES if lies_in(module, room)), key=len)]


def home(module: str) -> str:
    """Return the part of the package in which a module may import freely."""
    parts = module.split('.')
    return '.'.join(parts[:2] if parts[0] == PROGRAMS else parts[:1])


def may_import(module: str, name: str) -> bool:
    """Whether the rules let this module import this name."""
    rule, (top, _, rest) = rule_of(module), name.partition('.')
    if top == PACKAGE:
        return any(lies_in(rest, room) for room in (home(module), *rule.ours))
    if top in sys.stdlib_module_names:
        return not rule.pure or top not in IMPURE or name == SEEDABLE
    return bool(re.match(rf'({rule.others})\b', name))


def module_of(name: str) -> str | None:
    """Return the module of ours in which an imported name is found."""
    inside = name.removeprefix(PACKAGE).lstrip('.')
    while inside not in MODULES and inside:
        inside = inside.rpartition('.')[0]
    return inside if name.startswith(PACKAGE) and inside else None


def imports() -> dict[str, set[str]]:
    """Return the modules of ours that each module imports."""
    found = {module: {module_of(name) for name in imported(path)} - {None, module}
             for module, path in MODULES.items()}
    return {module: {str(other) for other in others} for module, others in found.items()}


def at_depth(graph: dict[str, set[str]], depth: int) -> dict[str, set[str]]:
    """Fold a graph of modules into one of packages, `depth` names deep."""
    folded: dict[str, set[str]] = {}
    for module, others in graph.items():
        name = '.'.join(module.split('.')[:depth])
        folded.setdefault(name, set()).update('.'.join(o.split('.')[:depth]) for o in others)
    return {name: others - {name} for name, others in folded.items()}


def ring(graph: dict[str, set[str]]) -> list[str]:
    """Return a ring of imports, each importing the next; empty where there is none."""
    left = {name: set(others) for name, others in graph.items()}
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
    """Return all names of ours that the rules mention."""
    return {room for rule in rules for room in rule.ours} | set(RULES) | {PROGRAMS}


@pytest.mark.parametrize('module', MODULES)
def test_imports_only_what_its_room_allows(module: str) -> None:
    wrong = [name for name in imported(MODULES[module]) if not may_import(module, name)]
    assert not wrong, f'{module} may not import {wrong}: see RULES'


@pytest.mark.parametrize('module', [module for module in MODULES if rule_of(module).pure])
def test_calls_nothing_that_reaches_outside(module: str) -> None:
    assert not IMPURE_CALLS & set(plain_calls(MODULES[module]))


@pytest.mark.parametrize('depth', [1, 2, 3, 4])
def test_nothing_imports_itself_in_a_ring(depth: int) -> None:
    assert not ring(at_depth(imports(), depth))


def test_a_ring_is_found() -> None:
    graph = {'a': {'b'}, 'b': {'c', 'd'}, 'c': {'a'}, 'd': set[str]()}
    assert sorted(ring(graph)[:-1]) == ['a', 'b', 'c']
    assert not ring({'a': {'b', 'c'}, 'b': {'c'}, 'c': set[str]()})


def test_every_rule_names_what_exists() -> None:
    assert not rooms_named(RULES.values()) - set(MODULES) - {'__version__'}


def test_no_two_files_have_one_name() -> None:
    names = [path.stem for path in MODULES.values() if not path.stem.startswith('__')]
    assert not {name for name in names if names.count(name) > 1}


@pytest.mark.parametrize(('module', 'name'), [
    ('oi.codes', 'time'), ('oi.codes', 'create_oi_ros.odometry'), ('oi', 'serial'),
    ('driver.machine', 'random.random'), ('driver', 'create_oi_ros.sim.body'),
    ('sim.body.body', 'create_oi_ros.driver'), ('sim.body.body', 'os.path'),
    ('sim.server', 'create_oi_ros.link.port'), ('link.port', 'create_oi_ros.ros'),
    ('ros.messages', 'rclpy.node'), ('ros.node', 'create_oi_ros.sim.server'),
    ('apps.demo.tour', 'create_oi_ros.apps.run'), ('apps.run', 'create_oi_ros.sim'),
    ('robot', 'create_oi_ros.oi'),
])
def test_rules_refuse(module: str, name: str) -> None:
    assert not may_import(module, name)
