# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""docs/architecture.md names all rooms, and only files and functions that exist."""

import ast
from pathlib import Path
import re

from create_oi_ros.driver.state import Activity, OWNERS, StateEvent, TRANSITIONS
from support.source import PACKAGE, parsed, ROOT

PAGE = (ROOT / 'docs' / 'architecture.md').read_text('utf-8')
HOMES = (ROOT / PACKAGE, ROOT)
"""Where the paths of the page begin."""
SPANS = sorted(set(re.findall(r'`([^`\n]+)`', PAGE)))
FILES = [span for span in SPANS if re.match(r'[\w/]+(\.(py|md|xml|yaml|js)(: [\w.]+)?|/)$', span)]
"""Folders, files, and names in files: `oi/`, `robot.py`, `driver/machine.py: Driver.poll`."""
DEPTH = 2
"""How deep in the package a folder is still a room."""


def rows(mark: str) -> list[list[str]]:
    """Return the cells of the table after a mark, without its head."""
    table = PAGE.partition(f'<!-- {mark} -->\n')[2].partition('<!-- end -->')[0]
    return [line.strip('|').split('|') for line in table.splitlines()[2:]]


def quoted(cell: str) -> str:
    """Return the only code span in a cell."""
    span, = re.findall('`([^`]+)`', cell)
    return str(span)


def packages() -> set[str]:
    """Return the folders with Python files in the package, to the depth of rooms."""
    folders = {path.parent.relative_to(ROOT / PACKAGE)
               for path in (ROOT / PACKAGE).rglob('*.py')} - {Path()}
    return {f'{folder}/' for folder in folders if len(folder.parts) <= DEPTH}


def found(name: str) -> Path | None:
    """Return the file or folder that the page means."""
    return next((home / name for home in HOMES if (home / name).exists()), None)


def names_in(path: Path) -> set[str]:
    """Return all names that a file defines: `Driver`, `poll` and `Driver.poll`."""
    return defined(parsed(path).body, '')


def defined(body: list[ast.stmt], prefix: str) -> set[str]:
    """Return the names that these statements define, with and without their class."""
    names = set()
    for node in body:
        match node:
            case ast.ClassDef(name=name):
                names |= {name} | defined(node.body, f'{name}.')
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                names |= {name, prefix + name}
            case (ast.AnnAssign(target=ast.Name(id=name))
                  | ast.Assign(targets=[ast.Name(id=name)])):
                names |= {name, prefix + name}
    return names


def test_the_rooms_are_those_of_the_tree():
    named = {quoted(room) for room, *_ in rows('rooms')}
    assert {room for room in named if room.endswith('/')} == packages()


def test_what_the_page_names_exists():
    assert FILES
    for span in FILES:
        file, _, name = span.partition(': ')
        path = found(file)
        assert path is not None, f'no {file}'
        assert not name or name in names_in(path), f'{file} defines no {name}'


def test_the_activities_and_their_owners_are_those_of_the_driver():
    shown = {quoted(activity): quoted(owner) for activity, _, owner, _ in rows('activities')}
    assert shown == {activity.name: OWNERS[activity].name for activity in Activity}


def test_the_transitions_are_those_of_the_driver():
    everywhere = {(StateEvent.PORT_CLOSED.name, Activity.CLOSED.name),
                  (StateEvent.NO_ANSWER.name, Activity.CALLING.name)}
    for activity, *_, leads in rows('activities'):
        shown = set(re.findall(r'`(\w+)` → `(\w+)`', leads))
        row = TRANSITIONS[Activity[quoted(activity)]]
        actual = {(event.name, after.name) for event, after in row.items()}
        assert shown == actual - everywhere, activity
