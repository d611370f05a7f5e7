# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is in the repository's Python files, found without running them."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = 'create_oi_ros'


def modules(folder: str) -> dict[str, Path]:
    """Return the Python files under a folder, by dotted module name."""
    return {dotted(path): path for path in sorted((ROOT / folder).rglob('*.py'))}


@cache
def parsed(path: Path) -> ast.Module:
    """Return a file's syntax tree."""
    return ast.parse(path.read_text('utf-8'))


def dotted(path: Path) -> str:
    """Return the dotted module name of a file."""
    return '.'.join(path.relative_to(ROOT).with_suffix('').parts).removesuffix('.__init__')


def imported(path: Path) -> Iterator[str]:
    """Yield the full name of each import: `from os import path` yields `os.path`."""
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            around = path.relative_to(ROOT).parts[:-node.level] if node.level else ()
            origin = '.'.join(filter(None, (*around, node.module)))
            yield from (f'{origin}.{alias.name}' for alias in node.names)


def plain_calls(path: Path) -> Iterator[str]:
    """Yield `name()` or `name(...)` for each call of a name that is not an attribute."""
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            yield f'{node.func.id}(...)' if node.args or node.keywords else f'{node.func.id}()'
