# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Rules for imports: each layer imports only what RULES allows, and no imports form a ring.

A layer is a package or a module with a rule of its own. A pure layer has no clock, no thread, no
I/O and no unseeded random numbers.
"""

from dataclasses import dataclass
from graphlib import TopologicalSorter
import re
import sys

from support.source import imported, modules, PACKAGE, plain_calls


@dataclass(frozen=True)
class Rule:
    """What a layer may import, besides itself and the standard library."""

    ours: tuple[str, ...] = ()
    """Other layers of this package; '' is the package's own __init__."""
    others: str = '(?!)'
    """Pattern for names of other packages; the default matches none."""
    pure: bool = True
    """Whether it may not import IMPURE modules or make IMPURE_CALLS."""


MESSAGES = r'(builtin_interfaces|rcl_interfaces|std_srvs|\w+_msgs)\.(msg|srv|action)'
ROS = rf'rclpy|ament_index_python|{MESSAGES}'
BAGS = 'mcap|rosbags|zstandard'

# A module is in the layer with the longest name here that is the module or a package around it.
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
    'sim.world': Rule(ours=('sim', 'robot'), others='numpy'),
    'sim.world_files': Rule(ours=('sim.world',), pure=False),
    'sim.body': Rule(ours=('sim', 'sim.world', 'oi', 'robot')),
    'sim.firmware': Rule(ours=('sim', 'sim.body', 'sim.world', 'oi', 'robot')),
    'sim.server': Rule(ours=('sim', 'sim.firmware', 'sim.body', 'sim.world', 'sim.world_files',
                             'oi', 'oi.tools', 'robot'), pure=False),
    'link': Rule(ours=('driver', 'oi', 'oi.tools', 'robot'), others='serial', pure=False),
    'ros': Rule(ours=('ros.messages', 'link', 'driver',
                      'odometry', 'oi', 'oi.tools', 'robot', ''),
                others=rf'{ROS}|{BAGS}|yaml', pure=False),
    'ros.messages': Rule(ours=('driver', 'odometry', 'oi', 'oi.tools', 'robot'),
                         others=MESSAGES),
    'pages': Rule(pure=False),
    'apps': Rule(ours=('ros', 'pages', 'ros.messages', 'link', 'driver', 'odometry', 'oi',
                       'oi.tools', 'robot', 'sim.world_files', ''),
                 others=rf'{ROS}|{BAGS}|numpy|yaml|aiohttp|segno', pure=False),
}
PROGRAMS = 'apps'
"""Each program in this package is a layer of its own, under this rule."""
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


def lies_in(name: str, layer: str) -> bool:
    """Return whether a dotted name is a layer or something in it."""
    return not layer or f'{name}.'.startswith(f'{layer}.')


def named_layer(name: str) -> str:
    """Return the name in RULES under which a module of ours, or a name in it, falls."""
    return max((layer for layer in RULES if lies_in(name, layer)), key=len)


def layer_of(name: str) -> str:
    """Return the layer that a module of ours, or a name in it, is in."""
    layer = named_layer(name)
    return '.'.join(name.split('.')[:2]) if layer == PROGRAMS else layer


def may_import(module: str, name: str) -> bool:
    """Return whether the rules allow a module to import a name."""
    rule, (top, _, rest) = RULES[named_layer(module)], name.partition('.')
    if top == PACKAGE:
        return layer_of(rest) in (layer_of(module), *rule.ours)
    if top in sys.stdlib_module_names:
        return not rule.pure or top not in IMPURE or name == SEEDABLE
    return bool(re.match(rf'({rule.others})\b', name))


def module_of(name: str) -> str | None:
    """Return the module of ours that an imported name is or is in; None for other packages."""
    inside = name.removeprefix(PACKAGE).lstrip('.')
    while inside not in MODULES and inside:
        inside = inside.rpartition('.')[0]
    return inside if name.startswith(PACKAGE) and inside else None


def graph(depth: int) -> dict[str, set[str]]:
    """Return which packages import which; names of modules are cut after `depth` parts."""
    found: dict[str, set[str]] = {}
    for module, path in MODULES.items():
        others = {module_of(name) for name in imported(path)} - {None}
        name, *cut = ('.'.join(each.split('.')[:depth]) for each in (module, *others))
        found.setdefault(name, set()).update(set(cut) - {name})
    return found


def test_imports_and_calls_are_those_that_a_layer_allows() -> None:
    wrong = []
    for module, path in MODULES.items():
        wrong += [f'{module} imports {name}' for name in imported(path)
                  if not may_import(module, name)]
        if RULES[named_layer(module)].pure:
            wrong += [f'{module} calls {call}' for call in IMPURE_CALLS & {*plain_calls(path)}]
    assert not wrong, 'see RULES'


def test_nothing_imports_itself_in_a_ring() -> None:
    rules = {layer: {*rule.ours} - {layer} for layer, rule in RULES.items()}
    for imports in (*map(graph, (1, 2, 3, 4)), rules):
        TopologicalSorter(imports).prepare()  # CycleError names the ring


def test_every_rule_names_what_exists() -> None:
    named = {layer for rule in RULES.values() for layer in rule.ours} | RULES.keys()
    assert not named - MODULES.keys()
