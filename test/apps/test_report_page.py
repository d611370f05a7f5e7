# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The page of a report: its data is small and exact, its texts stay text."""

from base64 import b64decode
from itertools import accumulate
import json
from math import inf, nan, sin
import re
import zlib

from hypothesis import given
from hypothesis import strategies as st
import pytest

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')

from create_oi_ros.apps.report import page
from create_oi_ros.apps.report.page import kept, packed, steps, write
from create_oi_ros.apps.report.recording import Recording, Span, Spans

EVIL = '</script><img id=evil src=x onerror=alert(1)>$style'


def recorded(points: int = 1000) -> Recording:
    """Return a recording of a drive with a frame every 15 ms."""
    made = Recording('walk', 'MCAP', 0.0, points * 0.015, points)
    for tick in range(points):
        time = tick * 0.015
        made.odom.add(time, 0.2 * time, sin(time), 0.1 * time, 0.2 + 0.001 * (tick % 7), nan)
        made.commands.add(time, 0.2, -0.5)
    return made


def unpacked(text: str):
    """Return the data of a page, as its script reads it."""
    return json.loads(zlib.decompress(b64decode(text)))


def column(data, curve: str, name: str) -> list[float]:
    """Return a column of the data, without values that are no number."""
    found = data['curves'][curve][name]
    return [whole * found['unit'] for whole in accumulate(
        step for step in found['steps'] if step is not None)]


# Thinning.

@given(st.lists(st.floats(-10, 10) | st.just(nan), min_size=1, max_size=300),
       st.integers(8, 100))
def test_thinning_keeps_the_ends_every_peak_of_a_piece_and_no_more_than_asked(values, most):
    places = kept([values], most)
    assert len(places) <= max(most, 4) and places == sorted(set(places))
    assert {0, len(values) - 1} <= set(places)
    known = [value for value in values if value == value]
    if known:
        shown = [values[place] for place in places if values[place] == values[place]]
        assert (min(shown), max(shown)) == (min(known), max(known))


def test_few_points_all_stay():
    assert kept([[1.0] * 10], 10) == list(range(10))


def test_the_peaks_of_each_column_stay():
    up, down = [0.0] * 1000, [0.0] * 1000
    up[501], down[502] = 9.0, -9.0
    assert {501, 502} <= set(kept([up, down], 50))


# The data.

@given(st.lists(st.floats(-1e6, 1e6) | st.sampled_from([nan, inf, -inf])))
def test_steps_give_every_value_back_to_half_a_unit(values):
    found = steps(values, 0.001)
    assert [step is None for step in found] == [abs(value) in (inf,) or value != value
                                                for value in values]
    sums = [0.001 * each for each in accumulate(step for step in found if step is not None)]
    assert sums == pytest.approx([value for value in values if abs(value) < inf], abs=0.00051)


def test_a_recording_of_minutes_is_exact():
    made = recorded()
    data = unpacked(packed(made))
    assert column(data, 'odom', 't') == pytest.approx(list(made.odom.times))
    assert column(data, 'odom', 'y') == pytest.approx(list(made.odom['y']), abs=0.00051)
    assert column(data, 'commands', 'turn') == [-0.5] * 1000
    assert data['curves']['odom']['turn']['steps'] == [None] * 1000


def test_a_long_recording_is_thinned_as_far_as_its_size_demands(monkeypatch):
    made = recorded(20_000)
    whole = len(packed(made))
    monkeypatch.setattr(page, 'LARGEST', whole // 3)
    text = packed(made)
    times = column(unpacked(text), 'odom', 't')
    assert len(text) <= whole // 3 and page.FEWEST < len(times) < 20_000
    assert times[-1] == pytest.approx(made.odom.times[-1])
    monkeypatch.setattr(page, 'LARGEST', 1)
    assert len(column(unpacked(packed(made)), 'odom', 't')) <= page.FEWEST


def test_an_empty_recording_has_a_page(tmp_path):
    made = recorded(0)
    assert unpacked(packed(made))['curves']['odom']['x']['steps'] == []
    write(made, tmp_path / 'page.html')


# The page.

def test_texts_of_a_bag_are_no_html(tmp_path):
    made = recorded(10)
    made.name, made.faults, made.undefined = EVIL, [EVIL], [EVIL]
    made.settings = {EVIL: EVIL}
    made.spans['mode'].all.append(Span(0.0, EVIL, 0.1, EVIL))
    made.warnings[EVIL] = Spans()
    made.warnings[EVIL].all.append(Span(0.0, EVIL, 0.1))
    write(made, tmp_path / 'page.html')
    text = (tmp_path / 'page.html').read_text()
    assert '<img' not in text and text.count('&lt;img') == 11
    assert len(re.findall('</script>', text)) == 2


def test_the_page_asks_for_nothing_and_runs_nothing_but_its_own(tmp_path):
    write(recorded(10), tmp_path / 'page.html')
    text = (tmp_path / 'page.html').read_text()
    assert "default-src 'none'; script-src 'sha256-" in text and "style-src 'sha256-" in text
    for word in ('http:', 'https:', 'src=', 'url(', '@import', 'innerHTML', 'eval('):
        assert word not in text
    assert not re.search(r'<link|^import |^export ', text, re.MULTILINE)
