# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes the report: one HTML page that needs no other file."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from hashlib import sha256
from html import escape
from importlib import resources
from pathlib import Path
from string import Template

from ... import pages
from ...pages.one_file import one_script
from ...ros.whole_file import write_whole
from .page_data import packed
from .recording import Recording
from .summary import absent, clock, events, summary, TimelineEvent, warnings

LONGEST = 2000
"""Rows of a table; the rest is only counted."""
PAGE, ENTRY = 'report.html', 'report.js'
STYLES = ('base.css', 'report.css')


def write(recording: Recording, target: Path) -> None:
    """Write the report; OSError: why it cannot be."""
    write_whole(target, _html(recording))


def _html(recording: Recording) -> bytes:
    """Return the page, in UTF-8. Texts of the bag go in escaped, or as JSON that is no script."""
    folder = resources.files(__package__) / 'live'
    files = {each.name: each.read_text('utf-8') for each in folder.iterdir()} | pages.files()
    style = '\n'.join(files[name] for name in STYLES)
    script = '\n' + one_script({
        name: text for name, text in files.items() if name.endswith('.js')}, ENTRY)
    return Template(files[PAGE]).substitute(
        title=escape(f'What the robot did: {recording.name}'),
        style=style, script=script, data=packed(recording),
        policy=f'script-src {_digest(script)}; style-src {_digest(style)}',
        summary='\n'.join(f'<p>{escape(line)}</p>' for line in summary(recording)),
        absent=_absent(recording), events=_event_table(events(recording)),
        warnings=_event_table(warnings(recording)),
        settings=_settings(recording)).encode('utf-8', 'replace')


def _digest(text: str) -> str:
    """Return what a content security policy calls this inline text."""
    return f"'sha256-{b64encode(sha256(text.encode()).digest()).decode()}'"


def _absent(recording: Recording) -> str:
    names = ', '.join(absent(recording))
    return f'<p>Not recorded: {escape(names)}.</p>' if names else ''


def _event_table(shown: list[TimelineEvent]) -> str:
    """Return a table whose rows jump to their time."""
    if not shown:
        return '<p>Nothing.</p>'
    rows = [f'<tr data-time="{each.time:.3f}"><td class="time"><button type="button">'
            f'{clock(each.time)}</button></td><td class="kind">{escape(each.kind)}</td>'
            f'<td>{escape(each.text)}</td></tr>' for each in shown[:LONGEST]]
    rest = len(shown) - LONGEST
    more = f'<p>And {rest} more.</p>' if rest > 0 else ''
    return '<table>' + '\n'.join(rows) + f'</table>{more}'


def _settings(recording: Recording) -> str:
    if not recording.settings:
        return '<p>Not in the bag: record /diagnostics to have them.</p>'
    return _table(list(recording.settings.items()))


def _table(rows: Sequence[tuple[str, ...]]) -> str:
    lines = [''.join(f'<td>{escape(cell)}</td>' for cell in row) for row in rows]
    return '<table>' + '\n'.join(f'<tr>{line}</tr>' for line in lines) + '</table>'
