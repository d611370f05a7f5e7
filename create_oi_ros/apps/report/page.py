"""The report as one HTML page with nothing beside it, or as a picture alone."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from io import BytesIO
from pathlib import Path

from .drawing import draw, save
from .recording import Recording
from .story import clock, complaints, Happening, happenings, summary

LONGEST = 2000
"""Rows of a table; what is beyond is counted only."""
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
{happened}
<h2>What the diagnostics warned of</h2>
{warned}
<h2>Driver version and parameters</h2>
{settings}
</body></html>
"""


def write(recording: Recording, target: Path) -> None:
    """Write the report; the suffix says as what."""
    figure = draw(recording)
    if target.suffix == '.png':
        save(figure, target)
        return
    picture = BytesIO()
    save(figure, picture)
    target.write_text(PAGE.format(
        title=escape(f'What the robot did: {recording.name}'),
        summary='<br>'.join(map(escape, summary(recording))),
        picture=b64encode(picture.getvalue()).decode('ascii'),
        happened=_happenings(happenings(recording), ''),
        warned=_happenings(complaints(recording), 'Nothing.'),
        settings=_settings(recording)), 'utf-8')


def _happenings(told: list[Happening], nothing: str) -> str:
    if not told:
        return f'<p>{nothing or "Nothing."}</p>'
    rows = [(str(number), clock(each.time), each.kind, each.text)
            for number, each in enumerate(told[:LONGEST], 1)]
    rest = len(told) - LONGEST
    more = f'<p>And {rest} more.</p>' if rest > 0 else ''
    return _table(('', 'time', 'what', ''), rows) + more


def _settings(recording: Recording) -> str:
    if not recording.settings:
        return '<p>The bag does not have them: record /diagnostics.</p>'
    return _table(('name', 'value'), list(recording.settings.items()))


def _table(heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [''.join(f'<th>{escape(head)}</th>' for head in heads)]
    lines += [''.join(f'<td>{escape(cell)}</td>' for cell in row) for row in rows]
    return '<table>' + '\n'.join(f'<tr>{line}</tr>' for line in lines) + '</table>'
