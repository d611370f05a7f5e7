# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is in the repository's Python files and documentation pages, found without running them."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
import re
import shlex

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


# Documentation pages: fenced blocks, and the commands in them.


BLOCK = re.compile(r'(?:^<!-- ([^\n]*?) -->\n)?^```(\w*)\n(.*?)^```$', re.M | re.S)
INLINE = re.compile(r'`(ros2 [^`]+)`')
PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').rglob('*.md'))]
EXAMPLES = [ROOT / 'config' / 'create.yaml', *sorted((ROOT / 'launch').glob('*.py'))]
"""Files whose comments have commands, a line each."""
REAL_PORT = re.compile(r'/dev/(ttyUSB0|create)\b')


@dataclass(frozen=True)
class Block:
    """One fenced block: the comment just before it, its language, its text."""

    mark: str
    language: str
    text: str


def blocks(path: Path) -> list[Block]:
    """Return the fenced blocks of a page, in order."""
    return [Block(*found) for found in BLOCK.findall(path.read_text('utf-8'))]


def ros2_commands() -> list[tuple[str, ...]]:
    """Return all whole `ros2` commands that we document, each once, with PORT for a real port."""
    return [*dict.fromkeys(
        tuple(REAL_PORT.sub('PORT', word) for word in words) for words in _ros2_commands()
        if '...' not in words and len(words) > (3 if words[1] in ('run', 'launch') else 2))]


def _ros2_commands() -> Iterator[list[str]]:
    for page in PAGES:
        for block in blocks(page):
            lines = block.text.replace('\\\n', ' ').splitlines()
            yield from (shlex.split(line, comments=True) for line in lines if line[:5] == 'ros2 ')
        yield from map(shlex.split, INLINE.findall(BLOCK.sub('', page.read_text('utf-8'))))
    for file in EXAMPLES:
        yield from map(shlex.split, re.findall(
            '^(?:    |# )(ros2 .+)', file.read_text('utf-8'), re.M))
