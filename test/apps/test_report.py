# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A report shows what is in a bag, or prints one sentence why it cannot."""

from bisect import bisect_right
from contextlib import closing
from math import inf, isnan, nan
from pathlib import Path
import shutil
import sqlite3
import subprocess
import sys

import pytest

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')
pytest.importorskip('mcap', reason='no mcap here: see tools/pins.txt')

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
from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import CompressionMode, StoragePlugin, Writer
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
    """Return a whole bag, in MCAP."""
    return bags.write(tmp_path_factory.mktemp('bags') / 'walk')


@pytest.fixture(scope='module')
def recording(tmp_path_factory) -> Recording:
    """Return the recording of a bag with a gap."""
    return read(bags.write(tmp_path_factory.mktemp('bags') / 'walk', gap=(10.0, 11.0)))


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


# Bags are read in the forms that rosbag2 writes, and in those that a killed recorder leaves.


UNCLOSED = 'its recorder did not close it'
FEEDBACK = '/rotate_angle/_action/feedback'


def told(recording: Recording) -> str:
    """Return the summary of a bag."""
    return ' '.join(summary(recording))


@pytest.fixture(scope='module')
def whole(bag) -> Recording:
    """Return what is in the whole bag."""
    return read(bag)


def copied(bag: Path, target: Path, *, feedback: bool = False, slices: int = 1, **options) -> Path:
    """Write the messages of a bag anew, in slices of its time; return the folder, unindexed."""
    target.mkdir()
    with next(bag.glob('*.mcap')).open('rb') as stream:
        messages = list(make_reader(stream).iter_messages())
    for part in range(slices):
        with (target / f'walk_{part}.mcap').open('wb') as file:
            writer = McapWriter(file, **options)
            writer.start(profile='ros2')
            known: dict[int, int] = {}
            if feedback:
                unknown = writer.register_schema(
                    'create_oi_msgs/action/RotateAngle_FeedbackMessage', 'unknown', b'')
                channel = writer.register_channel(FEEDBACK, 'cdr', unknown)
                writer.add_message(channel, bags.BEGAN, b'\0\1\0\0', bags.BEGAN)
            for schema, kind, message in messages[part * len(messages) // slices:
                                                  (part + 1) * len(messages) // slices]:
                if kind.id not in known:
                    known[kind.id] = writer.register_channel(
                        kind.topic, 'cdr', writer.register_schema(
                            schema.name, schema.encoding, schema.data))
                time = message.log_time
                writer.add_message(known[kind.id], time, message.data, time)
            writer.finish()
    return target


def assert_same(recording: Recording, whole: Recording) -> None:
    """Assert that all is there that is in the whole bag."""
    assert list(recording.odom['x']) == list(whole.odom['x'])
    assert events(recording) == events(whole)
    assert recording.events.settings == whole.events.settings


def test_feedback_of_actions_which_rosbag2_does_not_define_is_skipped(bag, whole, tmp_path):
    recording = read(copied(bag, tmp_path / 'walk', feedback=True))
    assert_same(recording, whole)
    assert not recording.faults


@pytest.mark.parametrize('options', [{'use_chunking': False}, {'slices': 11}], ids=str)
def test_a_bag_without_chunks_and_index_or_in_many_files_is_whole_without_metadata(
        bag, whole, tmp_path, options):
    """`--storage-preset-profile fastwrite`, `--max-bag-duration`."""
    recording = read(copied(bag, tmp_path / 'walk', **options))
    assert_same(recording, whole)
    assert not recording.faults


def test_a_file_that_is_missing_is_named(bag, tmp_path):
    shutil.copytree(bag, tmp_path / 'walk')
    metadata = tmp_path / 'walk' / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace(
        'relative_file_paths:\n', 'relative_file_paths:\n  - walk_9.mcap\n'))
    assert 'walk_9.mcap is missing' in told(read(tmp_path / 'walk'))
    (tmp_path / 'walk' / 'walk_9.mcap').symlink_to('nowhere')
    assert 'walk_9.mcap: ' in told(read(tmp_path / 'walk'))
    metadata.write_text('rosbag2: [')
    assert read(tmp_path / 'walk').odom


@pytest.mark.parametrize('options', [{}, {'use_chunking': False}], ids=['chunks', 'none'])
def test_a_file_that_was_cut_off_is_read_up_to_its_last_whole_part(bag, tmp_path, options):
    copy = copied(bag, tmp_path / 'walk', chunk_size=50_000, **options)
    file, = copy.glob('*.mcap')
    content = file.read_bytes()
    for share in (0.3, 0.6):
        for more in range(3):  # also in the middle of a number, or of a message
            file.write_bytes(content[:round(len(content) * share) + more])
            recording = read(copy)
            assert recording.odom and recording.faults == [
                f'{UNCLOSED}, so the last seconds may be missing']


def test_what_follows_a_damaged_chunk_is_read(bag, whole, tmp_path):
    copy = copied(bag, tmp_path / 'walk', chunk_size=50_000,
                  compression=CompressionType.NONE)
    file, = copy.glob('*.mcap')
    spoilt = bytearray(file.read_bytes())
    spoilt[len(spoilt) // 2] ^= 0xFF
    file.write_bytes(spoilt)
    recording = read(copy)
    assert 'The bag is not whole: a chunk is damaged: crc validation failed' in told(recording)
    assert len(whole.odom) > len(recording.odom) > 0.8 * len(whole.odom)
    assert recording.odom.times[-1] == whole.odom.times[-1]


def test_the_log_of_a_database_that_was_not_closed_is_read(whole, tmp_path):
    """`--storage-preset-profile resilient`, and `kill -9`: what is newest is in the log only."""
    bag = bags.write(tmp_path / 'walk', storage=StoragePlugin.SQLITE3)
    file, = bag.glob('*.db3')
    (tmp_path / 'killed').mkdir()
    with closing(sqlite3.connect(file)) as database:
        newest = list(database.execute('SELECT * FROM messages WHERE timestamp > ?', [
            bags.BEGAN + 6 * 10**9]))
        assert newest
        database.execute('DELETE FROM messages WHERE timestamp > ?', [bags.BEGAN + 6 * 10**9])
        database.commit()
        assert database.execute('PRAGMA journal_mode=WAL').fetchone() == ('wal',)
        database.executemany('INSERT INTO messages VALUES (?, ?, ?, ?)', newest)
        database.commit()
        for each in bag.glob('*.db3*'):
            shutil.copy(each, tmp_path / 'killed')
    before = {each.name: each.read_bytes() for each in (tmp_path / 'killed').iterdir()}
    recording = read(tmp_path / 'killed')
    assert_same(recording, whole)
    assert UNCLOSED in told(recording) and 'The recording has no gap' not in told(recording)
    assert before == {each.name: each.read_bytes() for each in (tmp_path / 'killed').iterdir()}


@pytest.mark.parametrize('storage', list(StoragePlugin), ids=lambda each: each.name)
@pytest.mark.parametrize('compression', [CompressionMode.FILE, CompressionMode.MESSAGE],
                         ids=lambda each: each.name)
def test_compressed_bags_are_read_by_folder_and_by_file(whole, tmp_path, storage, compression):
    bag = bags.write(tmp_path / 'walk', storage=storage, compression=compression)
    file, = (each for each in bag.iterdir() if each.suffix != '.yaml')
    for path in (bag, file):
        recording = read(path)
        assert_same(recording, whole)
        assert not recording.faults


def test_a_compressed_file_that_was_cut_off_is_read_as_far_as_it_goes(tmp_path):
    bag = bags.write(tmp_path / 'walk', 40.0, compression=CompressionMode.FILE)
    file, = bag.glob('*.zstd')
    file.write_bytes(file.read_bytes()[:file.stat().st_size * 9 // 10])
    recording = read(bag)
    assert recording.odom and 'The bag is not whole: ' in told(recording)


def test_reset_odometry_and_reset_pose_are_events(tmp_path, monkeypatch):
    drives = bags.odometry

    def odometry(time: float):
        moved = drives(time - 4.0 if time >= 4.0 else time)
        moved.pose.pose.position.y += 3.0 if time >= 8.0 else 0.0
        return moved
    monkeypatch.setattr(bags, 'odometry', odometry)
    recording = read(bags.write(tmp_path / 'walk'))
    jumps = [each for each in events(recording) if each.kind == 'odometry']
    assert [each.time for each in jumps] == pytest.approx([4.0, 8.0], abs=0.03)
    assert 'reset_odometry' in jumps[0].text and 'jumps by 3.00 m' in jumps[1].text
    assert travelled(recording) == pytest.approx(2.4, abs=0.02)
