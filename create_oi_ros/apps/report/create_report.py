# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The command `create_report`: make one HTML page from a bag, which needs no other file.

The page's data are small: curves in whole steps, thinned as far as the size demands, compressed.
"""

from __future__ import annotations

import argparse
from base64 import b64encode
from collections.abc import Callable, Iterable, Mapping, Sequence
from hashlib import sha256
from html import escape
from importlib import resources
import json
from math import isfinite, isnan
from pathlib import Path
import re
from string import Template
import sys
from typing import Any
import zlib

from ... import pages
from ...ros.collector import KINDS, Span
from ...ros.odometry_model import write_whole
from .recording import CURVES, read, Recording
from .summary import absent, events, summary, TimelineEvent, warnings

LONGEST = 2000
"""Rows of a table; the rest is only counted."""
PAGE, ENTRY = 'report.html', 'report'
STYLES = ('base.css', 'report.css')


def write(recording: Recording, target: Path) -> None:
    """
    Write the page, in UTF-8; OSError: why it cannot be.

    Texts of the bag go in escaped, or as JSON that is no script.
    """
    folder = resources.files(__package__) / 'live'
    files = {each.name: each.read_text('utf-8') for each in folder.iterdir()} | pages.files()
    style = '\n'.join(files[name] for name in STYLES)
    script = '\n' + one_script(files, ENTRY)
    lacks = absent(recording)
    page = Template(files[PAGE]).substitute(
        title=escape(f'What the robot did: {recording.name}'),
        style=style, script=script, data=packed(recording),
        policy=f'script-src {_digest(script)}; style-src {_digest(style)}',
        summary='\n'.join(f'<p>{escape(line)}</p>' for line in summary(recording)),
        absent=f'<p>Not recorded: {escape(", ".join(lacks))}.</p>' if lacks else '',
        events=_event_table(events(recording)),
        warnings=_event_table(warnings(recording)),
        settings=_settings(recording))
    write_whole(target, page.encode('utf-8', 'replace'))


def _digest(text: str) -> str:
    """Return what a content security policy calls this inline text."""
    return f"'sha256-{b64encode(sha256(text.encode()).digest()).decode()}'"


def _event_table(shown: list[TimelineEvent]) -> str:
    """Return a table whose rows jump to their time, which the page's script writes."""
    if not shown:
        return '<p>Nothing.</p>'
    rows = [f'<tr data-time="{each.time:.3f}"><td class="time">'
            f'<button type="button"></button></td><td class="kind">{escape(each.kind)}</td>'
            f'<td>{escape(each.text)}</td></tr>' for each in shown[:LONGEST]]
    rest = len(shown) - LONGEST
    more = f'<p>And {rest} more.</p>' if rest > 0 else ''
    return '<table>' + '\n'.join(rows) + f'</table>{more}'


def _settings(recording: Recording) -> str:
    if not recording.events.settings:
        return '<p>Not in the bag: record /diagnostics to have them.</p>'
    rows = [f'<tr><td>{escape(name)}</td><td>{escape(value)}</td></tr>'
            for name, value in recording.events.settings.items()]
    return '<table>' + '\n'.join(rows) + '</table>'


# One script of several modules.

IMPORT = re.compile(r"^import (\{[^}]*\}) from '\./(\w+)\.js';\n", re.MULTILINE)
EXPORT = re.compile(r'^export ((?:async )?(?:function|class|const) (\w+))', re.MULTILINE)
"""The only forms that our modules use: named imports, and exports where a name is declared."""


def one_script(modules: Mapping[str, str], entry: str) -> str:
    """Return a script that runs the module `entry`, behind those that it imports."""
    functions: dict[str, str] = {}

    def add(name: str) -> None:
        """Add a module as a function that is called once, and returns what it exports."""
        text = modules[f'{name}.js']
        for _, imported in IMPORT.findall(text):
            if imported not in functions:
                add(imported)
        exported = ', '.join(each for _, each in EXPORT.findall(text))
        body = EXPORT.sub(r'\1', IMPORT.sub(r'const \1 = \2_js;\n', text))
        functions[name] = (f'const {name}_js = await (async () => {{\n{body}\n'
                           f'return {{ {exported} }};\n}})();\n')
    add(entry)
    return ''.join(functions.values())


# The data.

LARGEST = 2_800_000
"""Bytes of the data in the page: with all else, an hour stays below 3 MB."""
PAUSE = 0.6
"""Seconds without a command after which its line ends."""
FEWEST = 500
"""Points of a curve that stay, whatever the size."""
TIME = 0.001
"""Step of the times, seconds."""
POSE = ('x', 'y', 'yaw')
"""Columns without peaks that must stay."""


def steps(values: Iterable[float], unit: float) -> list[int | None]:
    """Return values as whole steps of a unit, each from the one before; None: it is no number."""
    found: list[int | None] = []
    before = 0
    for value in values:
        if not isfinite(value):
            found.append(None)
            continue
        whole = round(value / unit)
        found.append(whole - before)
        before = whole
    return found


def _bars(spans: Iterable[Span]) -> list[list[Any]]:
    return [[round(span.start, 3), round(span.end, 3), span.text] for span in spans]


def page_data(recording: Recording, most: int) -> dict[str, Any]:
    """Return all that the page draws, with at most `most` points of each curve."""
    curves: dict[str, Any] = {}
    happened = recording.events
    for kind, units in CURVES.items():
        curve = getattr(recording, kind)
        places = kept([curve[name] for name in units if name not in POSE], most)
        columns = {'t': (curve.times, TIME)} | {
            name: (curve[name], unit) for name, unit in units.items()}
        curves[kind] = {name: {'unit': unit, 'steps': steps((values[at] for at in places), unit)}
                        for name, (values, unit) in columns.items()}
    return {
        'seconds': recording.seconds, 'pause': PAUSE, 'damage': recording.damage,
        'began': recording.began, 'jumps': [round(each.start, 3) for each in happened.jumps.all],
        'gaps': _bars(recording.gaps),
        'spans': [{'name': name, 'spans': _bars(happened.spans[name].all)} for name in KINDS
                  if name.replace(' ', '_') in recording.heard],
        'curves': curves}


def packed(recording: Recording) -> str:
    """Return the page's data as text of letters, thinned only as far as its size demands."""
    most = max(len(getattr(recording, name)) for name in CURVES) + 1
    while True:
        text = json.dumps(page_data(recording, most), allow_nan=False, separators=(',', ':'))
        found = b64encode(zlib.compress(text.encode(), zlib.Z_BEST_COMPRESSION)).decode('ascii')
        if len(found) <= LARGEST or most <= FEWEST:
            return found
        most = max(FEWEST, int(most * LARGEST / len(found) * 0.95))


def kept(columns: Sequence[Sequence[float]], most: int) -> list[int]:
    """
    Return the indices of at most `most` points.

    The curve is cut into equal pieces. Of each piece its first point stays, and of each column the
    points with the least and the greatest value, so no peak is lost. All stay if there are few.
    """
    count = len(columns[0])
    if count <= most:
        return list(range(count))
    pieces = max(1, (most - 1) // (2 * len(columns) + 1))
    chosen = {count - 1}
    for piece in range(pieces):
        first, end = piece * count // pieces, (piece + 1) * count // pieces
        chosen.add(first)
        for column in columns:
            known = [place for place in range(first, end) if not isnan(column[place])]
            if known:
                chosen |= {min(known, key=column.__getitem__), max(known, key=column.__getitem__)}
    return sorted(chosen)


# The command.

WIDTH = 30
"""Characters of the progress bar."""


def bar(label: str) -> Callable[[float], None]:
    """Return a function that draws a progress bar on stderr, if that is a terminal."""
    def show(part: float) -> None:
        done = round(WIDTH * part)
        print(f'\r{label} [{"#" * done}{"." * (WIDTH - done)}] {part:4.0%}',
              end='\n' if part >= 1 else '', file=sys.stderr, flush=True)
    return show if sys.stderr.isatty() else lambda part: None


def _target(text: str) -> Path:
    target = Path(text)
    if target.suffix != '.html':
        raise argparse.ArgumentTypeError(f'{text!r} must end in .html: the report is a page')
    return target


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `create_report`; UserError or OSError says why no report can be made."""
    parser = argparse.ArgumentParser(
        prog='create_report', description='Show on one page what a robot did, from a bag.')
    parser.add_argument('bag', type=Path, metavar='BAG',
                        help='folder of a bag, or one of its files')
    parser.add_argument('-o', dest='target', type=_target, default=Path('report.html'),
                        metavar='FILE.html', help='the page (default: %(default)s)')
    parser.add_argument('--robot', metavar='NAMESPACE',
                        help='which robot, if the bag holds several; / is one without a namespace')
    options = parser.parse_args(arguments)
    write(read(options.bag, options.robot, bar(f'reading {options.bag.name}')), options.target)
    print(options.target)
    return 0
