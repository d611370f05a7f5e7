# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Tables for Markdown, and the blocks of a page that are generated.

A generated block stands between two comments: `<!-- LABEL -->` and `<!-- end -->`.
"""

from collections.abc import Callable, Iterable, Sequence
import re

Row = Sequence[str]


def table(heading: Row, rows: Iterable[Row]) -> str:
    """Return a Markdown table, with a line end after each row."""
    lines = [heading, ['---'] * len(heading), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


def rewritten(page: str, label: str, block: Callable[[str], str]) -> str:
    """
    Return a page with its generated blocks made again.

    `label` is the pattern of the labels of these blocks; `block` returns the text for a label.
    """
    return re.sub(
        rf'(?P<start><!-- (?P<label>{label}) -->\n).*?(?P<end><!-- end -->)',
        lambda found: found['start'] + block(found['label']) + found['end'], page,
        flags=re.DOTALL)
