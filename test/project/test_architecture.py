# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""docs/architecture.md names all packages, and only files and functions that exist."""

import ast
from pathlib import Path
import re

from support.source import PACKAGE, parsed, ROOT

PAGE = (ROOT / 'docs' / 'architecture.md').read_text('utf-8')
HOMES = (ROOT / PACKAGE, ROOT)
"""Where the paths of the page begin."""
SPANS = sorted(set(re.findall(r'`([^`\n]+)`', PAGE)))
FILES = [span for span in SPANS if re.match(r'[\w/]+(\.(py|md|xml|yaml|js)(: [\w.]+)?|/)$', span)]
"""Folders, files, and names in files: `oi/`, `robot.py`, `driver/machine.py: Driver.poll`."""
DEPTH = 2
"""How deep in the package a folder has a row of the table."""


def packages() -> set[str]:
    """Return the folders with Python files in the package, down to DEPTH."""
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


def test_the_packages_are_those_of_the_tree():
    assert set(re.findall('^\\| `([^`]+/)` ', PAGE, re.MULTILINE)) == packages()


def test_what_the_page_names_exists():
    assert FILES
    for span in FILES:
        file, _, name = span.partition(': ')
        path = found(file)
        assert path is not None, f'no {file}'
        assert not name or name in names_in(path), f'{file} defines no {name}'
