# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Bench results: they are saved, and in the documents as they were measured."""

import document
from results import Figure, figures_of, keep, load, rows
from support.source import ROOT


def test_every_bench_program_has_results_and_a_place_in_the_documents():
    pages = {path: path.read_text('utf-8') for path in (ROOT / 'docs').glob('*.md')}
    for path in (ROOT / 'bench').glob('bench_*.py'):
        assert figures_of(load(), path.stem)
        assert any(f'<!-- bench {path.stem} -->' in page for page in pages.values()), path.stem
    for path, page in pages.items():
        assert document.documented(page, load()) == page, f'{path}: run `make docs`'


def test_a_figure_says_whether_its_target_was_met():
    assert Figure('a', 1.0, 's', 2.0).verdict == 'met'
    assert Figure('a', 3.0, 's', 2.0).verdict == 'missed'
    assert Figure('a', 3.0, 's', 2.0, at_least=True).verdict == 'met'
    table = rows([Figure('a', 2.0, 's', 1.0, worst=2.5), Figure('b', 1.0, 's', beside='more')])
    assert table == [['what', 'value', 'target', 'beside'],
                     ['a', '2 s (at worst 2.5)', '**<= 1**', ''], ['b', '1 s', '', 'more']]


def test_results_are_kept_beside_those_of_other_programs(tmp_path):
    path = tmp_path / 'results.json'
    first, second = [Figure('a', 1.0, 's', 2.0)], [Figure('b', 3.0, 'ms', worst=4.0)]
    keep('one', first, {'date': 'then'}, path)
    keep('two', second, {'date': 'now'}, path)
    assert figures_of(load(path), 'one') == first
    assert figures_of(load(path), 'two') == second
