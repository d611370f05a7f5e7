# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""README and interface page agree with the code."""

import ast
import re

from create_oi_ros.ros.reference import POLICY, rewritten, TABLES
from support.pages import blocks, check_ros2, commands
from support.source import modules, PACKAGE, parsed, ROOT

README = (ROOT / 'README.md').read_text('utf-8')
INTERFACE = (ROOT / 'docs' / 'interface.md').read_text('utf-8')
LOG_LINE = re.compile(r'`([^`]*\.\.\.[^`]*)`')


def test_generated_blocks_are_made_from_the_code():
    for name, labels in (('docs/interface.md', TABLES), ('config/sros2_policy.xml', POLICY)):
        text = (ROOT / name).read_text('utf-8')
        assert all(f'<!-- {label} -->' in text for label in labels)
        assert rewritten(text) == text, 'run `make docs`'


def test_the_scripts_in_the_page_are_the_examples():
    for name in ('drive.py', 'square.py'):
        text = (ROOT / 'examples' / name).read_text()
        program = re.sub(r'\A(#.*\n)+\n*', '', text)  # without copyright and licence
        assert f'```python\n{program}```' in INTERFACE


def test_names_in_ros2_commands_exist():
    for page in [ROOT / 'README.md', *(ROOT / 'docs').glob('*.md')]:
        if page.name == 'security.md':  # `ros2 security`: test_security
            continue
        for block in blocks(page):
            for words in commands(block.text) if block.language in ('', 'bash') else ():
                if words[0] == 'ros2':
                    check_ros2(words)


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
    pages = README, (ROOT / 'docs' / 'if_nothing_happens.md').read_text('utf-8')
    tables = [page[page.index('| symptom |'):].partition('\n\n')[0] for page in pages]
    return [line for table in tables for row in table.splitlines()[2:]
            for line in LOG_LINE.findall(row.split(' | ')[1])]


def test_the_log_lines_of_the_faults_are_those_of_the_code():
    said = texts()
    assert quoted()
    for line in quoted():
        for clause in re.split(r'\.\.\.|[:;,] ', line):
            assert clause.strip() in said, line
