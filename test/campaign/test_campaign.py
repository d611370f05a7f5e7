# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The campaign's table, and what tries the mutants: that failures are seen and nothing is left."""

from contextlib import closing
from importlib import import_module
import os
from pathlib import Path
from random import Random
import select
import sqlite3
import subprocess
import sys

import pytest

from campaign import campaign
from campaign.campaign import Part
from campaign.mutant_parts import NO_MUTANTS, PARTS, ROOMS
from campaign.mutants import COPIED, drop_bare_stars, keep_sample, Mutant, ROOT, Tried
from campaign.mutants import main as mutants_main

ORDERS = Random(1)
"""Draws the order in which cosmic-ray's file has the mutants: another one each time."""
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
        Part('end', 'nonsense', (), ('nonsense',), 1),
        Part('fuzz', 'frames', (), ('40', '7'), 1)))
    monkeypatch.setattr(sys, 'argv', ['campaign', '--short'])
    assert campaign.main() == 1
    *_, failed, passed = capsys.readouterr().out.strip().splitlines()
    assert failed.startswith('| end | nonsense | ') and failed.endswith(' | FAILED |')
    assert passed.startswith('| fuzz | frames | 40 frames, seed 7: ')
    assert passed.endswith(' | ok |')
    assert 'nonsense' in (tmp_path / 'log/end.log').read_text()


def test_a_part_that_hangs_is_ended_and_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(campaign, 'LOGS', tmp_path)
    tried = campaign.attempt(Part('sequences', 'for ever', (), (), 0.01), ['999'])
    assert (tried.ok, tried.said) == (False, 'ended after 0.01 min: it hangs')


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


def test_no_file_of_the_rooms_is_forgotten():
    package = ROOT / 'create_oi_ros'
    files = {path.relative_to(package).with_suffix('').as_posix() for room in ROOMS
             for path in (package / room).glob('[!_]*.py')}
    assert {each for each in PARTS if not each.startswith('link/')} | NO_MUTANTS == files


@pytest.mark.parametrize('part', campaign.PARTS, ids=lambda part: part.name)
def test_every_part_can_be_started(part):
    assert callable(import_module(f'campaign.{part.name}').main)


def test_the_table_counts_who_survived():
    mutants = [Mutant('AddNot', 1, 2, killed, 'if not a:') for killed in (True, True, False)]
    assert Tried(mutants, 7).row('oi/wire') == ('`oi/wire.py`', '3 of 7', '2', '66.7', '1')


def jobs(path: Path) -> list[str]:
    """Make a file as cosmic-ray does: ten mutants, one of them filtered out already."""
    path.unlink(missing_ok=True)
    with closing(sqlite3.connect(path)) as file, file:
        file.executescript(
            'CREATE TABLE work_items (job_id); CREATE TABLE work_results (job_id);'
            'CREATE TABLE mutation_specs (job_id, operator_name, operator_args, occurrence,'
            '                             start_pos_row, start_pos_col)')
        for number in ORDERS.sample(range(10), 10):
            file.execute('INSERT INTO work_items VALUES (?)', (f'job {number}',))
            file.execute('INSERT INTO mutation_specs VALUES (?, ?, ?, ?, 1, ?)',
                         (f'job {number}', 'AddNot', '{}', number, number))
        file.execute("INSERT INTO work_results VALUES ('job 3')")
    return sampled(path)


def sampled(path: Path) -> list[str]:
    """Return which mutants cosmic-ray would try."""
    with closing(sqlite3.connect(path)) as file:
        return sorted(job for job, in file.execute(
            'SELECT job_id FROM work_items JOIN mutation_specs USING (job_id) '
            'WHERE job_id NOT IN (SELECT job_id FROM work_results)'))


def test_a_sample_has_the_same_mutants_each_time_and_says_of_how_many(tmp_path):
    drawn = []
    for seed in ('19', '19', '20'):
        assert len(jobs(tmp_path / 'session')) == 9
        assert keep_sample(tmp_path / 'session', 4, seed) == 9
        drawn.append(sampled(tmp_path / 'session'))
    assert [len(each) for each in drawn] == [4, 4, 4]
    assert drawn[0] == drawn[1] != drawn[2]


@pytest.mark.parametrize('sample', [None, 9, 40])
def test_a_sample_that_is_large_enough_has_all_mutants(tmp_path, sample):
    there = jobs(tmp_path / 'session')
    assert keep_sample(tmp_path / 'session', sample, '19') == 9
    assert sampled(tmp_path / 'session') == there


def test_a_star_before_parameters_is_no_product(tmp_path):
    jobs(tmp_path / 'session')
    drop_bare_stars(tmp_path / 'session', ['*, a * b*,'])
    kept = sampled(tmp_path / 'session')
    assert len(kept) == 7 and not {'job 0', 'job 8'} & set(kept)


@pytest.mark.parametrize('sample', ['0', '-3', 'all'])
def test_a_sample_of_nothing_is_refused(sample, monkeypatch, capsys):
    monkeypatch.setattr(sys, 'argv', ['mutants', '--sample', sample])
    with pytest.raises(SystemExit, match='2'):
        mutants_main()
    assert f'--sample: {sample} is no number of mutants; allowed: 1' in capsys.readouterr().err
