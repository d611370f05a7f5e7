"""Writes the report: one HTML page that needs no other file, or a picture."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from io import BytesIO
from pathlib import Path

from ...ros.whole_file import write_whole
from .drawing import draw, save
from .recording import Recording
from .summary import clock, events, summary, TimelineEvent, warnings

LONGEST = 2000
"""Rows of a table; the rest is only counted."""
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width"><title>{title}</title>
<style>
body {{ font: 15px/1.45 sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em; }}
img {{ width: 100%; }}
table {{ border-collapse: collapse; }}
td, th {{ padding: .15em .8em; text-align: left; border-bottom: 1px solid #ddd; }}
td:first-child {{ font-variant-numeric: tabular-nums; }}
</style></head><body>
<h1>{title}</h1>
<p>{summary}</p>
<img alt="Track, speeds, battery, timeline and link of the recording"
 src="data:image/png;base64,{picture}">
<h2>What happened</h2>
{events}
<h2>Warnings of the diagnostics</h2>
{warnings}
<h2>Driver version and parameters</h2>
{settings}
</body></html>
"""


def write(recording: Recording, target: Path) -> None:
    """Write the report as HTML or PNG, by the suffix of the file; OSError: why it cannot be."""
    picture = BytesIO()
    save(draw(recording), picture)
    content = picture.getvalue()
    write_whole(target, content if target.suffix == '.png' else _html(recording, content))


def _html(recording: Recording, picture: bytes) -> bytes:
    """Return the page, in UTF-8."""
    return PAGE.format(
        title=escape(f'What the robot did: {recording.name}'),
        summary='<br>'.join(map(escape, summary(recording))),
        picture=b64encode(picture).decode('ascii'),
        events=_event_table(events(recording), ''),
        warnings=_event_table(warnings(recording), 'Nothing.'),
        settings=_settings(recording)).encode('utf-8', 'replace')


def _event_table(shown: list[TimelineEvent], nothing: str) -> str:
    if not shown:
        return f'<p>{nothing or "Nothing."}</p>'
    rows = [(str(number), clock(each.time), each.kind, each.text)
            for number, each in enumerate(shown[:LONGEST], 1)]
    rest = len(shown) - LONGEST
    more = f'<p>And {rest} more.</p>' if rest > 0 else ''
    return _table(('', 'time', 'what', ''), rows) + more


def _settings(recording: Recording) -> str:
    if not recording.settings:
        return '<p>Not in the bag: record /diagnostics to have them.</p>'
    return _table(('name', 'value'), list(recording.settings.items()))


def _table(heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [''.join(f'<th>{escape(head)}</th>' for head in heads)]
    lines += [''.join(f'<td>{escape(cell)}</td>' for cell in row) for row in rows]
    return '<table>' + '\n'.join(f'<tr>{line}</tr>' for line in lines) + '</table>'
