"""Imports run one way, and the pure parts have no clock, no thread, no chance and no I/O."""

from dataclasses import dataclass
import re
import sys

import pytest

from source import imported, modules, PACKAGE, plain_calls


@dataclass(frozen=True)
class Rule:
    """What a part may import besides itself and the standard library, and whether it is pure."""

    ours: str = '(?!)'  # matches nothing
    others: str = '(?!)'
    pure: bool = True


MESSAGES = r'(builtin_interfaces|\w+_msgs)\.(msg|srv)'

# A module falls under the longest name here that it is or lies in; '' is the node and its like.
RULES = {
    'oi': Rule(),
    'oi.__main__': Rule(pure=False),
    'oi.door': Rule(pure=False),
    'odometry': Rule(others='numpy'),
    'driver': Rule(ours='oi|odometry'),
    'sim': Rule(ours='oi'),
    'sim.server': Rule(ours='oi', pure=False),
    'sim.lines': Rule(ours='oi', pure=False),
    'port': Rule(others='serial', pure=False),
    'convert': Rule(ours=r'oi|odometry|driver\.ModeStatus', others=MESSAGES),
    'view': Rule(ours='oi|convert', others=MESSAGES),
    'view.terminal': Rule(pure=False),
    'view.graph': Rule(ours='topics|services', others='rclpy|' + MESSAGES, pure=False),
    'view.command': Rule(ours='ending', others='rclpy', pure=False),
    'start': Rule(ours=r'\w+', pure=False),
    '': Rule(ours=r'(?!sim\b)\w+', others='', pure=False),
}
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


def rule_of(module: str) -> Rule:
    """Return the rule that a module falls under."""
    return RULES[max((part for part in RULES if not part or f'{module}.'.startswith(f'{part}.')),
                     key=len)]


def may_import(module: str, name: str) -> bool:
    """Whether the rules let this module import this name."""
    rule, (top, _, rest) = rule_of(module), name.partition('.')
    if top == PACKAGE:
        itself = module.split('.')[0]
        return bool(re.match(rf'({itself}|{rule.ours})\b', rest))
    if top in sys.stdlib_module_names:
        return not rule.pure or top not in IMPURE or name == SEEDABLE
    return bool(re.match(rule.others, name))


@pytest.mark.parametrize('module', MODULES)
def test_imports_only_what_its_place_allows(module: str) -> None:
    wrong = [name for name in imported(MODULES[module]) if not may_import(module, name)]
    assert not wrong, f'{module} may not import {wrong}: see RULES'


@pytest.mark.parametrize('module', [module for module in MODULES if rule_of(module).pure])
def test_calls_nothing_that_reaches_outside(module: str) -> None:
    assert not IMPURE_CALLS & set(plain_calls(MODULES[module]))


@pytest.mark.parametrize(('module', 'name'), [
    ('oi.codes', 'time'), ('oi.codes', 'create_oi_ros.odometry'), ('oi', 'serial'),
    ('driver.machine', 'random.random'), ('driver', 'create_oi_ros.sim.body'),
    ('sim.body', 'create_oi_ros.driver'), ('sim.body', 'os.path'),
    ('sim.server', 'create_oi_ros.port'), ('port', 'create_oi_ros.oi'),
    ('convert', 'rclpy.node'), ('convert', 'create_oi_ros.driver.Driver'),
    ('node', 'create_oi_ros.sim.server'),
])
def test_rules_refuse(module: str, name: str) -> None:
    assert not may_import(module, name)
