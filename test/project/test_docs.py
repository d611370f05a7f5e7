# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Files, links and `make` targets that the documentation names exist."""

from collections.abc import Iterator
import os
from pathlib import Path
import re
import subprocess

import pytest

from support.source import ROOT

MADE = {'build', 'install', 'log'}
"""Folders that `make` creates."""
FOLDERS = {path.name for path in ROOT.iterdir() if path.is_dir() and path.name[0] != '.'} - MADE
PAGES = sorted(path for place in ('.', 'docs', 'docs/with') for ending in ('*.md', '*.rst')
               for path in (ROOT / place).glob(ending))
SOURCES = sorted(path for folder in ('create_oi_ros', 'test', 'bench', 'tools', 'examples')
                 for path in (ROOT / folder).rglob('*.py'))
FILE = re.compile(
    rf'(?<![\w./-])(?:{"|".join(sorted(FOLDERS))})/[\w./*-]*\.[a-z]+\b(?!/)')
"""The path of a file in this repository, from its root."""
LINK = re.compile(r'\]\(([^)#\s]+)(?:#[^)]*)?\)')
TARGET = re.compile(r'`make ([a-z][a-z-]*)|^make ([a-z][a-z-]*)', re.MULTILINE)
"""A target in inline code, or at the start of a line of a code block."""
FENCED = re.compile(r'^```.*?^```', re.MULTILINE | re.DOTALL)
MAKEFILE = (ROOT / 'Makefile').read_text('utf-8')
TARGETS = set(re.findall(r'^([a-z][a-z-]*):', MAKEFILE, re.MULTILINE))


def name(path: Path) -> str:
    """Return the path of a file from the repository's root, to name its test."""
    return str(path.relative_to(ROOT))


def targets(text: str) -> Iterator[str]:
    """Yield the `make` targets that a page or a source file names."""
    code = '\n'.join(FENCED.findall(text))
    for inline, line in TARGET.findall(text):
        if inline or f'\nmake {line}' in code:
            yield inline or line


@pytest.mark.parametrize('page', PAGES, ids=name)
def test_files_that_a_page_names_exist(page: Path) -> None:
    named = set(FILE.findall(page.read_text('utf-8')))
    assert not {path for path in named if not list(ROOT.glob(path))}


@pytest.mark.parametrize('page', PAGES, ids=name)
def test_links_of_a_page_lead_to_files(page: Path) -> None:
    links = set(LINK.findall(page.read_text('utf-8')))
    local = {link for link in links if not link.startswith(('https:', 'http:', 'mailto:'))}
    assert not {link for link in local if not (page.parent / link).exists()}


@pytest.mark.parametrize('page', PAGES + SOURCES, ids=name)
def test_make_has_every_target_that_is_named(page: Path) -> None:
    assert set(targets(page.read_text('utf-8'))) <= TARGETS


def test_every_target_is_phony() -> None:
    phony = re.search(r'^\.PHONY: (.*)', MAKEFILE, re.MULTILINE)
    assert phony and set(phony[1].split()) == TARGETS


def test_make_help_names_every_target() -> None:
    # Not as a part of the make that may run this test: it would print that it enters a folder.
    environment = {name: value for name, value in os.environ.items() if 'MAKE' not in name}
    shown = subprocess.run(['make', 'help'], cwd=ROOT, text=True, capture_output=True, check=True,
                           env=environment)
    lines = shown.stdout.splitlines()
    assert {line.split()[1] for line in lines if not line.startswith('make  ')} == TARGETS
    assert all(len(line) <= 99 and line[21] != ' ' for line in lines)


def test_names_in_text_are_found() -> None:
    text = 'See `test/a.py`, test/b/*.py and src/test/c.py.\n```\nmake bench ARGS=5\n```\nmake\n'
    assert FILE.findall(text) == ['test/a.py', 'test/b/*.py']
    assert list(targets(f'{text} Run `make docs`, or make python.')) == ['bench', 'docs']
