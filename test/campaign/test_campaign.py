# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The campaign's table, and what tries the mutants: that failures are seen and nothing is left."""

from importlib import import_module
import os
import select
import subprocess
import sys

import pytest

from campaign import campaign
from campaign.campaign import Part
from campaign.mutants import COPIED, Mutant, PARTS, ROOT, row

CHILD = """
import subprocess, sys
def test_that_leaves_a_process_behind():
    child = subprocess.Popen([sys.executable, '-c', 'input()'], stdin=subprocess.PIPE,
                             start_new_session=True)
    open('child', 'w').write(str(child.pid))
    child.stdin = None
    assert {passes}
    while {hangs}:
        pass
"""


def test_a_part_that_fails_is_in_the_table_and_does_not_end_the_others(
        tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(campaign, 'LOGS', tmp_path / 'log')
    monkeypatch.setattr(campaign, 'PARTS', (
        Part('end', 'nonsense', (), ('nonsense',)), Part('fuzz', 'frames', (), ('40', '7'))))
    monkeypatch.setattr(sys, 'argv', ['campaign', '--short'])
    assert campaign.main() == 1
    *_, failed, passed = capsys.readouterr().out.strip().splitlines()
    assert failed.startswith('| end | nonsense | ') and failed.endswith(' | FAILED |')
    assert passed.startswith('| fuzz | frames | 40 frames, seed 7: ')
    assert passed.endswith(' | ok |')
    assert 'nonsense' in (tmp_path / 'log/end.log').read_text()


@pytest.mark.parametrize(('passes', 'hangs', 'code'), [
    (True, False, 0), (False, False, 1), (True, True, 1)])
def test_a_mutant_survives_if_its_tests_pass_and_leaves_no_process(tmp_path, passes, hangs, code):
    (tmp_path / 'test_it.py').write_text(CHILD.format(passes=passes, hangs=hangs))
    done = subprocess.run(
        [sys.executable, '-m', 'campaign.one_mutant', '1' if hangs else '60', 'test_it.py'],
        cwd=tmp_path, timeout=120, check=False,
        env={**os.environ, 'PYTHONPATH': f'{ROOT / "test"}:{os.environ.get("PYTHONPATH", "")}'})
    assert done.returncode == code
    if not hangs:  # else it may have been ended before it had started the child
        assert ends(int((tmp_path / 'child').read_text()))


def ends(pid: int) -> bool:
    """Wait for the end of a process; False if it does not end."""
    try:
        process = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    with os.fdopen(process, 'rb', buffering=0):
        return bool(select.select([process], [], [], 30)[0])


def test_mutants_are_made_of_files_that_exist_and_tried_by_tests_that_exist():
    assert all((ROOT / name).exists() for name in COPIED)
    for part, tests in PARTS.items():
        assert (ROOT / 'create_oi_ros' / f'{part}.py').is_file()
        assert all((ROOT / 'test' / test).is_file() for test in tests)


@pytest.mark.parametrize('part', campaign.PARTS, ids=lambda part: part.name)
def test_every_part_can_be_started(part):
    assert callable(import_module(f'campaign.{part.name}').main)


def test_the_table_counts_who_survived():
    mutants = [Mutant('AddNot', 1, 2, killed, 'if not a:') for killed in (True, True, False)]
    assert row('oi/wire', mutants) == ('`oi/wire.py`', '3', '2', '66.7', '1')
