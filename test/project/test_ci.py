# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The workflow for GitHub runs the commands of the README and of the Makefile, and no others."""

import json
import re
import shlex
import tomllib
from typing import Any

import yaml

from support.source import ROOT

FILE = ROOT / '.github' / 'workflows' / 'ci.yml'
TEXT = FILE.read_text('utf-8')
JOBS: dict[str, dict[str, Any]] = yaml.safe_load(TEXT)['jobs']
MAKEFILE = (ROOT / 'Makefile').read_text('utf-8')
PAGES = ''.join((ROOT / name).read_text('utf-8') for name in ('README.md', 'CONTRIBUTING.md'))
EVERYWHERE = {'source /opt/ros/jazzy/setup.bash', 'apt-get update', 'rosdep update',
              'colcon test-result --verbose'}
"""What a README need not say: such commands prepare a fresh machine, or only print."""
VALUE = re.compile(r'\$\{\{ matrix\.(\w+) \}\}')


def commands(job: dict[str, Any]) -> list[str]:
    """Return the commands of a job, with each value of its matrix."""
    lines = [line.strip() for step in job['steps'] for line in step.get('run', '').splitlines()]
    matrix = job.get('strategy', {}).get('matrix', {})
    return [filled for line in lines for filled in variants(line, matrix)]


def variants(line: str, matrix: dict[str, list[str]]) -> list[str]:
    """Return a line with each value of the matrix that it names."""
    found = VALUE.search(line)
    return [line] if found is None else [
        line.replace(found[0], value) for value in matrix[found[1]]]


def said(command: str) -> bool:
    """Return whether a page or the Makefile has a command."""
    words = shlex.split(command.removeprefix('sudo '))
    if ' '.join(words) in EVERYWHERE:
        return True
    if words[0] == 'make':
        targets = [word for word in words[1:] if '=' not in word]
        return all(re.search(rf'^{target}:', MAKEFILE, re.M) for target in targets)
    # -y answers a question that people are asked.
    plain = re.escape(' '.join(word for word in words if word != '-y'))
    return bool(re.search(rf'(^|`)(sudo )?{plain}($|`)', PAGES, re.M))


def test_the_commands_of_the_jobs_are_those_of_the_pages() -> None:
    assert not {command for job in JOBS.values() for command in commands(job) if not said(command)}
    assert not said('make everything') and not said('colcon build --all') and said('make test')
    assert TEXT.count('\n  # Has not yet run on GitHub.\n') == len(JOBS)


def test_the_versions_of_python_are_those_that_are_supported() -> None:
    check = (ROOT / 'tools' / 'check.py').read_text('utf-8')
    oldest, newest = (int(number) for number in re.findall(r'\(3, (\d+)\)', check)[:2])
    supported = [f'3.{minor}' for minor in range(oldest, newest + 1)]
    assert JOBS['wheels']['strategy']['matrix']['python'] == supported
    ruff = tomllib.loads((ROOT / 'pyproject.toml').read_text('utf-8'))['tool']['ruff']
    assert ruff['target-version'] == f'py3{oldest}'


def test_the_commands_of_the_container_are_those_of_the_pages() -> None:
    file = (ROOT / 'Dockerfile').read_text('utf-8').replace('\\\n', ' ')
    devcontainer = json.loads((ROOT / '.devcontainer' / 'devcontainer.json').read_text('utf-8'))
    whole = re.findall('^RUN (.*)', file, re.M) + [devcontainer['postCreateCommand'][-1]]
    each = [command.strip() for run in whole for command in run.split(' && ')]
    assert [command for command in each if not said(command)] == [
        'rm -rf /var/lib/apt/lists/*', 'cd /ws']
