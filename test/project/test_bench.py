# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Bench results: they are saved, compared, and in the documents as they were measured."""

import re

import pytest

import compare
from create_oi_ros.oi.tools.markdown import block_pattern
import document
import everything
from results import Figure, figures_of, keep, load, rows
from support.source import ROOT

PAGE = ROOT / 'docs' / 'performance.md'
PROGRAMS = sorted(path.stem for path in (ROOT / 'bench').glob('bench_*.py'))


@pytest.mark.parametrize('program', PROGRAMS)
def test_every_bench_program_has_results_and_a_place_in_the_documents(program):
    figures = figures_of(load(), program)
    assert figures
    shown = ''.join(page.read_text('utf-8') for page in (ROOT / 'docs').glob('*.md'))
    assert program in shown


@pytest.mark.parametrize('name', ['performance.md', 'odometry.md', 'goals.md', 'robot_check.md'])
def test_the_documents_say_what_was_measured(name):
    page = PAGE.with_name(name).read_text('utf-8')
    assert document.documented(page, load()) == page


def test_measured_numbers_are_in_tables_only():
    prose = block_pattern(document.LABEL).sub('', PAGE.read_text('utf-8'))
    amounts = re.findall(r'\d+(?:\.\d+)?\s*(?:%|[mµu]s\b|s\b|MB\b|x\b|times)', prose)
    assert set(amounts) == {'15 ms'}  # the slot, a number of the manual


def test_a_figure_knows_whether_its_target_was_met():
    assert Figure('a', 1.0, 's', 2.0).verdict == 'met'
    assert Figure('a', 3.0, 's', 2.0).verdict == 'missed'
    assert Figure('a', 3.0, 's', 2.0, at_least=True).verdict == 'met'
    assert Figure('a', 3.0, 's').verdict == ''


def test_results_are_kept_beside_those_of_other_programs(tmp_path):
    path = tmp_path / 'results.json'
    first, second = [Figure('a', 1.0, 's', 2.0)], [Figure('b', 3.0, 'ms', worst=4.0)]
    keep('one', first, {'date': 'then'}, path)
    keep('two', second, {'date': 'now'}, path)
    assert figures_of(load(path), 'one') == first
    assert figures_of(load(path), 'two') == second


def test_two_results_stand_side_by_side(tmp_path):
    old, new = tmp_path / 'old.json', tmp_path / 'new.json'
    keep('one', [Figure('a', 2.0, 's')], {'date': 'then'}, old)
    keep('one', [Figure('a', 1.0, 's'), Figure('b', 1.0, 's')], {'date': 'now'}, new)
    assert compare.compared('one', load(old), load(new))[1:] == [
        ['a', '2 s', '1 s', '-50 %', ''], ['b', '-', '1 s', '', '']]


def test_a_table_has_a_cell_for_each_heading():
    table = rows([Figure('a', 2.0, 's', 1.0, worst=3.0, beside='x'), Figure('b', 1.0, 's')])
    assert {len(row) for row in table} == {6}
    assert table[1] == ['a', '2 s', '3', '<= 1', 'missed', 'x']


def test_make_bench_runs_every_program_but_the_longest():
    assert {path.stem for path in everything.programs()} == (
        {*PROGRAMS} - {'bench_odometry', 'bench_goals', 'bench_check'})


def test_a_program_that_fails_does_not_keep_the_others_from_running(tmp_path, capfd):
    bad, good = tmp_path / 'bad.py', tmp_path / 'good.py'
    bad.write_text('raise SystemExit(1)')
    good.write_text('import sys; print(sys.argv[1])')
    assert everything.run_all([bad, good], ['option']) == ['bad']
    said = capfd.readouterr().out
    assert 'option' in said and said.endswith('Failed, older results kept: bad\n')
