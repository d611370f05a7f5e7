# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Reads documentation pages: fenced blocks, and the commands in them."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
import re
import shlex

from create_oi_ros.ros.topics import ALL_TOPICS

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r'(?:^<!-- ([^\n]*?) -->\n)?^```(\w*)\n(.*?)^```$', re.M | re.S)
INLINE = re.compile(r'`(ros2 [^`]+)`')
PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').rglob('*.md'))]
EXAMPLES = [ROOT / 'config' / 'create.yaml', *sorted((ROOT / 'launch').glob('*.py'))]
"""Files whose comments have commands, a line each."""
REAL_PORT = re.compile(r'/dev/(ttyUSB0|create)\b')
OURS = {f'/{topic.name.lstrip("/")}' for topic in ALL_TOPICS} | {'/cmd_vel'}
"""Full names of all topics of a driver without a namespace."""


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
