# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A report shows what is in a bag, or prints one sentence why it cannot."""

from bisect import bisect_right
from math import inf, isnan, nan
from pathlib import Path
import subprocess
import sys

import pytest

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')

from base64 import b64decode
from itertools import accumulate
import json
from math import sin
import re
import zlib

from create_oi_msgs.msg import Mode
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from std_msgs.msg import String

from create_oi_ros.apps.report import create_report
from create_oi_ros.apps.report.create_report import kept, main, packed, steps, write
from create_oi_ros.apps.report.recording import read, Recording
from create_oi_ros.apps.report.summary import clock, events, summary, travelled, warnings
from create_oi_ros.ros import programs
from create_oi_ros.ros.diagnostics import PARAMETERS
from support import bags


@pytest.fixture(scope='module')
def bag(tmp_path_factory) -> Path:
    """Return a bag with a gap."""
    return bags.write(tmp_path_factory.mktemp('bags') / 'walk', gap=(10.0, 11.0))


@pytest.fixture(scope='module')
def recording(bag):
    """Return the recording of this bag."""
    return read(bag)


def refusal(path: Path, *arguments: str) -> str:
    """Return what the command says of a bag that it cannot show."""
    with pytest.raises(programs.UserError) as refused:
        main([str(path), '-o', str(path.parent / 'none.html'), *arguments])
    said = str(refused.value)
    assert '\n' not in said and not (path.parent / 'none.html').exists()
    return said


def test_curves_are_those_of_the_bag(recording):
    assert recording.seconds == pytest.approx(12.0, abs=0.02)
    assert recording.odom['turn'][0] == 0.5
    assert travelled(recording) == pytest.approx(0.4 * 0.5 * 12, rel=0.01)
    assert len(recording.commands) > 200
    assert recording.battery['charge'][0] == pytest.approx(90)
    assert recording.link['frames'][0] == 66


def test_events_have_their_time_cause_and_place(recording):
    found = {(each.kind, each.text): each.time for each in events(recording)}
    assert found['bumper', 'Bump left and right, 0.5 s'] == pytest.approx(3.0, abs=0.05)
    assert found['cliff', 'Cliff front left, 1.0 s'] == pytest.approx(8.0, abs=0.05)
    gap = found['gap', 'Gap, 1.0 s: no odometry: the robot was not heard']
    assert gap == pytest.approx(10.0, abs=0.1)
    assert found['mode', 'Mode PASSIVE (a cliff)'] == pytest.approx(8.9, abs=0.1)
    assert any(kind == 'song' for kind, _ in found)
    bump = recording.events.spans['bumper'].all[0]
    at = bisect_right(recording.odom.times, bump.start) - 1
    x, y = recording.odom['x'][at], recording.odom['y'][at]
    assert (x, y - 0.4) == (pytest.approx(0.4, abs=0.01), pytest.approx(-0.03, abs=0.03))


def test_version_parameters_and_warnings_are_shown(recording):
    assert recording.events.settings == {'version': '9.8.7', 'port': '/dev/robot'}
    warned, = warnings(recording)
    assert warned.text.startswith('warning: bytes arrive damaged')
    assert '6 damaged frames' in ' '.join(summary(recording))


@pytest.mark.parametrize('name', ['report.png', 'report', 'report.htm'])
def test_a_file_that_is_no_page_is_refused(bag, tmp_path, capsys, name):
    with pytest.raises(SystemExit) as ended:
        main([str(bag), '-o', str(tmp_path / name)])
    assert ended.value.code == 2
    assert 'must end in .html' in capsys.readouterr().err


def test_of_several_robots_one_must_be_named_and_one_without_a_namespace_is_called_slash(tmp_path):
    bag = bags.write(tmp_path / 'walk', 1.0)
    assert refusal(bag, '--robot', 'nobody') == f'{bag} has no robot nobody: it has /'
    fleet = bags.write(tmp_path / 'fleet', 2.0, robots=('', 'robot2'))
    assert 'name one with --robot: /, robot2' in refusal(fleet)
    assert read(fleet, '/').odom
    chosen = read(fleet, 'robot2')
    assert len(chosen.odom) == 133 and chosen.events.settings['version'] == '9.8.7'
    assert 'no robot robot3: it has /, robot2' in refusal(fleet, '--robot', 'robot3')


def test_what_is_no_bag_of_a_robot_gets_a_sentence(tmp_path):
    (tmp_path / 'folder').mkdir()
    (tmp_path / 'a.mcap').write_bytes(b'')
    (tmp_path / 'b.db3').write_bytes(b'no database at all')
    (tmp_path / 'c.txt').write_text('text')
    with Writer(tmp_path / 'empty', version=9, storage_plugin=StoragePlugin.MCAP):
        pass
    with Writer(tmp_path / 'foreign', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        other = writer.add_connection('/chatter', 'std_msgs/msg/String', typestore=bags.STORE)
        writer.write(other, 5, serialize_message(String(data='hello')))
    for name, words in (
            ('nothing', 'there is no'), ('folder', 'neither .mcap nor .db3'),
            ('a.mcap', 'is empty'), ('empty', 'is empty'), ('foreign', '/chatter'),
            ('b.db3', 'cannot be read as a bag'), ('c.txt', 'cannot be read as a bag')):
        assert words in refusal(tmp_path / name)


@pytest.mark.parametrize('value', [nan, inf, -inf, 1e300, -1e300])
def test_impossible_values_are_left_out(tmp_path, monkeypatch, value):
    honest = bags.twist
    monkeypatch.setattr(bags, 'twist', lambda _, turn: honest(value, turn))
    bag = bags.write(tmp_path / 'bag', 1.0)
    main([str(bag), '-o', str(tmp_path / 'report.html')])
    recording = read(bag)
    assert all(map(isnan, recording.odom['speed']))
    assert not any(map(isnan, recording.odom['turn']))


@pytest.mark.parametrize(('seconds', 'text'), [
    (0, '0:00.0'), (75.26, '1:15.3'), (3725, '1:02:05'), (59.99, '1:00.0'), (3599.97, '1:00:00'),
    (119.94, '1:59.9')])
def test_times_read_well_and_never_have_sixty_seconds(seconds, text):
    assert clock(seconds) == text


def test_a_bag_without_odometry_is_still_shown(tmp_path):
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        mode = writer.add_connection('/mode', 'create_oi_msgs/msg/Mode', typestore=bags.STORE)
        for time in (0.0, 8.5):
            writer.write(mode, int(time * 1e9), serialize_message(bags.modes(time)))
    main([str(tmp_path / 'bag'), '-o', str(tmp_path / 'report.html')])
    recording = read(tmp_path / 'bag')
    assert [span.text for span in recording.events.spans['mode'].all] == ['SAFE', 'PASSIVE']
    assert recording.gaps[0].text == 'nothing was recorded'


def test_a_full_disk_leaves_the_old_report(tmp_path, unmeasured):
    bag = bags.write(tmp_path / 'walk', 1.0)
    target = tmp_path / 'report.html'
    target.write_text('the old one')
    full = 'import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (1024, 1024)); '
    done = subprocess.run(
        [sys.executable, '-c', full + programs.PROGRAMS['create_report'], str(bag), '-o',
         str(target)],
        capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert done.stderr == (
        f'create_report: {target}: File too large: nothing more can be written\n')
    assert target.read_text() == 'the old one' and {*tmp_path.iterdir()} == {bag, target}


# The page: its data is small and exact, its texts stay text.


EVIL = '</script><img id=evil src=x onerror=alert(1)>$style'


def recorded(points: int = 1000) -> Recording:
    """Return a recording of a drive with a frame every 15 ms."""
    made = Recording('walk', 0.0, points * 0.015, points)
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


# The data.

@given(st.lists(st.floats(-1e6, 1e6) | st.sampled_from([nan, inf, -inf])))
def test_steps_give_every_value_back_to_half_a_unit(values):
    found = steps(values, 0.001)
    assert [step is None for step in found] == [abs(value) in (inf,) or value != value
                                                for value in values]
    sums = [0.001 * each for each in accumulate(step for step in found if step is not None)]
    assert sums == pytest.approx([value for value in values if abs(value) < inf], abs=0.00051)


def test_a_long_recording_is_thinned_as_far_as_its_size_demands(monkeypatch):
    made = recorded(20_000)
    whole = len(packed(made))
    monkeypatch.setattr(create_report, 'LARGEST', whole // 3)
    text = packed(made)
    times = column(unpacked(text), 'odom', 't')
    assert len(text) <= whole // 3 and create_report.FEWEST < len(times) < 20_000
    assert times[-1] == pytest.approx(made.odom.times[-1])
    monkeypatch.setattr(create_report, 'LARGEST', 1)
    assert len(column(unpacked(packed(made)), 'odom', 't')) <= create_report.FEWEST


# The page.

def test_texts_of_a_bag_are_no_html(tmp_path):
    made = recorded(10)
    made.name, made.faults = EVIL, [EVIL]
    statuses = [DiagnosticStatus(name='create: serial link'), DiagnosticStatus(
        name=f'create: {PARAMETERS}', values=[KeyValue(key=EVIL, value=EVIL)]),
        DiagnosticStatus(name=f'create: {EVIL}', level=b'\x01', message=EVIL)]
    made.events.take('mode', 0.0, Mode(mode=Mode.PASSIVE, reason=EVIL))
    made.events.take('diagnostics', 0.0, DiagnosticArray(status=statuses))
    made.events.finish(0.1)
    write(made, tmp_path / 'page.html')
    text = (tmp_path / 'page.html').read_text()
    assert '<img' not in text and text.count('&lt;img') == 8
    assert len(re.findall('</script>', text)) == 2


def test_the_page_asks_for_nothing_and_runs_nothing_but_its_own(tmp_path):
    write(recorded(10), tmp_path / 'page.html')
    text = (tmp_path / 'page.html').read_text()
    assert "default-src 'none'; script-src 'sha256-" in text and "style-src 'sha256-" in text
    for word in ('http:', 'https:', 'src=', 'url(', '@import', 'innerHTML', 'eval('):
        assert word not in text
    assert not re.search(r'<link|^import |^export ', text, re.MULTILINE)
