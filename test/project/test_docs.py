# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the documentation names exists, and what it quotes is what code and benches say."""

import ast
from collections.abc import Iterator
import os
from pathlib import Path
import re
import subprocess

from document import BLOCKS, POLICY, rewritten
from results import figures_of, load
from support.source import modules, PACKAGE, parsed, ROOT

MADE = {'build', 'install', 'log', 'my'}
"""Folders that `make` creates, and a reader of the tutorial."""
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


def targets(text: str) -> Iterator[str]:
    """Yield the `make` targets that a page or a source file names."""
    code = '\n'.join(FENCED.findall(text))
    for inline, line in TARGET.findall(text):
        if inline or f'\nmake {line}' in code:
            yield inline or line


def test_files_and_links_of_the_pages_exist() -> None:
    missing = []
    for page in PAGES:
        text = page.read_text('utf-8')
        local = {link for link in LINK.findall(text)
                 if not link.startswith(('https:', 'http:', 'mailto:'))}
        missing += [f'{page}: {name}' for name in FILE.findall(text) if not list(ROOT.glob(name))]
        missing += [f'{page}: {link}' for link in local if not (page.parent / link).exists()]
    assert not missing


def test_make_has_every_target_that_is_named() -> None:
    assert not {(page, target) for page in PAGES + SOURCES
                for target in targets(page.read_text('utf-8')) if target not in TARGETS}


def make(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run make: not as a part of one that may run this test, which prints its folder."""
    environment = {name: value for name, value in os.environ.items() if 'MAKE' not in name}
    return subprocess.run(['make', *arguments], cwd=ROOT, text=True, capture_output=True,
                          env=environment)


def test_make_refuses_a_variable_that_it_does_not_know() -> None:
    refused = make('-n', 'run', 'port=/dev/ttyUSB0')
    assert refused.returncode == 2
    assert 'no variable is called port: allowed are PORT ARGS ' in refused.stderr
    assert make('-n', 'help', 'PORT=/dev/ttyUSB0', 'ARGS=--gyro').returncode == 0


def test_make_help_names_every_target() -> None:
    shown = make('help')
    assert shown.returncode == 0
    named = {line.split()[1] for line in shown.stdout.splitlines() if line[4:6] != '  '}
    phony = re.search(r'^\.PHONY: (.*)', MAKEFILE, re.MULTILINE)
    assert named == TARGETS == set(phony[1].split())


# docs/architecture.md names all packages, and only files and functions that exist.


PAGE = (ROOT / 'docs' / 'architecture.md').read_text('utf-8')
HOMES = (ROOT / PACKAGE, ROOT)
"""Where the paths of the page begin."""
SPANS = sorted(set(re.findall(r'`([^`\n]+)`', PAGE)))
FILES = [span for span in SPANS if re.match(r'[\w/]+(\.(py|md|xml|yaml|js)(: [\w.]+)?|/)$', span)]
"""Folders, files, and names in files: `oi/`, `robot.py`, `driver/machine.py: Driver.poll`."""


def defines(path: Path, name: str) -> bool:
    """Return whether a file defines a name: a class, a function, or a value."""
    pattern = rf'^(    )?((class|(async )?def) {name}\b|{name}\b(: [^=\n]+)? = )'
    return bool(re.search(pattern, path.read_text('utf-8'), re.MULTILINE))


def test_the_packages_are_those_of_the_tree():
    package = ROOT / PACKAGE
    folders = {f'{path.parent.relative_to(package)}/' for depth in ('*', '*/*')
               for path in package.glob(f'{depth}/*.py')}
    assert set(re.findall('^\\| `([^`]+/)` ', PAGE, re.MULTILINE)) == folders


def test_what_the_page_names_exists():
    assert FILES
    for span in FILES:
        file, _, name = span.partition(': ')
        path = next((home / file for home in HOMES if (home / file).exists()), None)
        assert path is not None, f'no {file}'
        assert all(defines(path, part) for part in name.split('.') if part), span


# README and interface page agree with the code.


README = (ROOT / 'README.md').read_text('utf-8')
LOG_LINE = re.compile(r'`([^`]*\.\.\.[^`]*)`')


def test_generated_blocks_are_made_from_the_code():
    files = [*(ROOT / 'docs').glob('*.md'), ROOT / 'bench' / 'RESULTS.md',
             ROOT / 'config' / 'sros2_policy.xml']
    texts = {path.name: path.read_text('utf-8') for path in files}
    assert all(f'<!-- {label} -->' in ''.join(texts.values()) for label in BLOCKS)
    assert all(f'<!-- {label} -->' in texts['sros2_policy.xml'] for label in POLICY)
    for name, text in texts.items():
        assert rewritten(text) == text, f'{name}: run `make docs`'


def test_a_wrong_row_is_made_again():
    page = (ROOT / 'docs' / 'open_interface.md').read_text('utf-8')
    assert rewritten(page.replace('| 137 | Drive |', '| 138 | Drive |')) == page


def texts() -> str:
    """Return the texts in the package's code; what varies in them is a line end."""
    found = []
    for path in modules(PACKAGE).values():
        for node in ast.walk(parsed(path)):
            match node:
                case ast.JoinedStr(values=parts):
                    found.append('\n'.join(str(part.value) for part in parts
                                           if isinstance(part, ast.Constant)))
                case ast.Constant(value=str(text)):
                    found.append(text)
    return '\n'.join(found)


def quoted() -> list[str]:
    """Return the log lines in the tables of faults."""
    page = (ROOT / 'docs' / 'if_nothing_happens.md').read_text('utf-8')
    table = page[page.index('| log line |'):].partition('\n\n')[0]
    common = README[README.index('| you see |'):].partition('\n\n')[0]
    return [*LOG_LINE.findall(common), *(
        line for row in table.splitlines()[2:] for line in LOG_LINE.findall(row.split(' | ')[0]))]


def test_the_log_lines_of_the_faults_are_those_of_the_code():
    said = texts()
    assert quoted()
    for line in quoted():
        for clause in re.split(r'\.\.\.|[:;,] ', line):
            assert clause.strip() in said, line


# Bench results: they are saved, and in the documents as they were measured.


def test_every_bench_program_has_results_and_a_place_in_the_documents():
    pages = {path: path.read_text('utf-8') for path in (
        *(ROOT / 'docs').glob('*.md'), ROOT / 'bench' / 'RESULTS.md')}
    for path in (ROOT / 'bench').glob('bench_*.py'):
        assert figures_of(load(), path.stem)
        assert any(f'<!-- bench {path.stem} -->' in page for page in pages.values()), path.stem
