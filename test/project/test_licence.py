# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Every source file says whose it is and under which licence it may be used."""

from pathlib import Path

import pytest

from support.source import ROOT

LINES = ('Copyright 2026 create_oi_ros contributors', 'SPDX-License-Identifier: Apache-2.0')
FOLDERS = ('.ci', '.github', 'bench', 'create_oi_ros', 'examples', 'launch', 'msg_defs', 'test',
           'tools', 'urdf')
KINDS = {'.py', '.sh', '.yml', '.msg', '.srv', '.action', '.js', '.css', '.html', '.urdf'}
NAMES = {'CMakeLists.txt', 'Makefile', 'Dockerfile', 'run'}
HEAD = 6
"""The lines must be among the first so many: a shebang or a document type comes before."""


def sources() -> list[Path]:
    """Return the source files: those of these kinds, not what `make` builds."""
    found = list(ROOT.iterdir())
    for folder in FOLDERS:
        found += (ROOT / folder).rglob('*')
    return sorted(path for path in found
                  if path.is_file() and (path.suffix in KINDS or path.name in NAMES))


@pytest.mark.parametrize('line', LINES)
def test_every_source_file_has_a_copyright_and_a_licence(line: str) -> None:
    lacking = [path.relative_to(ROOT) for path in sources()
               if not any(line in each for each in path.read_text('utf-8').splitlines()[:HEAD])]
    assert not lacking, f'write these two lines into them: {LINES}'


def test_all_folders_of_the_repository_are_searched() -> None:
    made = {'build', 'install', 'log'}
    folders = {path.name for path in ROOT.iterdir() if path.is_dir() and path.name[0] != '.'}
    without = {'config', 'docs', 'resource', 'rviz'}
    left = {name for name in folders - made
            if not name.startswith('demo-') and '.' not in name}
    assert left - {*FOLDERS} <= without and len(sources()) > 400


def test_the_licence_is_that_of_the_packages() -> None:
    name = LINES[1].rpartition(' ')[2]
    for folder in ('.', 'msg_defs'):
        assert f'<license>{name}</license>' in (ROOT / folder / 'package.xml').read_text('utf-8')
    assert 'Apache License' in (ROOT / 'LICENSE').read_text('utf-8')
