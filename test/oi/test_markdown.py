# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Tables for Markdown and the generated blocks of a page."""

from create_oi_ros.oi.tools.markdown import rewritten, table

PAGE = """\
# Page
<!-- table: one -->
old
<!-- end -->
between
<!-- table: two -->
<!-- end -->
<!-- other -->
kept
<!-- end -->
"""


def test_a_table_has_a_heading_a_rule_and_rows() -> None:
    assert table(('a', 'b'), [('1', '2'), ['3', '']]) == (
        '| a | b |\n| --- | --- |\n| 1 | 2 |\n| 3 |  |\n')


def test_only_the_blocks_with_the_label_are_made_again() -> None:
    after = rewritten(PAGE, r'table: \w+', lambda label: f'{label}!\n')
    assert after == PAGE.replace('old\n', 'table: one!\n').replace(
        '<!-- table: two -->\n', '<!-- table: two -->\ntable: two!\n')
    assert rewritten(after, r'table: \w+', lambda label: f'{label}!\n') == after


def test_a_block_is_copied_as_it_is() -> None:
    assert rewritten(PAGE, 'other', lambda _: r'\1 \g<end>') == PAGE.replace(
        'kept\n', r'\1 \g<end>')
