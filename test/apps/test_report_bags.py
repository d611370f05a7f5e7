# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Bags are read in the forms that rosbag2 writes, and in those that a killed recorder leaves."""

from contextlib import closing
from pathlib import Path
import shutil
import sqlite3

import pytest

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')
pytest.importorskip('mcap', reason='no mcap here: see tools/pins.txt')

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from create_oi_ros.apps.report.recording import read, Recording
from create_oi_ros.apps.report.summary import events, summary, travelled
from support import bags

UNCLOSED = 'its recorder did not close it'
FEEDBACK = '/rotate_angle/_action/feedback'


def told(recording: Recording) -> str:
    """Return the summary of a bag."""
    return ' '.join(summary(recording))


@pytest.fixture(scope='module')
def bag(tmp_path_factory) -> Path:
    """Return a whole bag, in MCAP."""
    return bags.write(tmp_path_factory.mktemp('bags') / 'walk')


@pytest.fixture(scope='module')
def whole(bag) -> Recording:
    """Return what is in it."""
    return read(bag)


def copied(bag: Path, target: Path, *, feedback: bool = False, slices: int = 1, **options) -> Path:
    """Write the messages of a bag anew, in slices of its time; return the folder, unindexed."""
    target.mkdir()
    with next(bag.glob('*.mcap')).open('rb') as stream:
        messages = list(make_reader(stream).iter_messages())
    for part in range(slices):
        with (target / f'walk_{part}.mcap').open('wb') as file:
            writer = Writer(file, **options)
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
    for kept in (0.3, 0.6):
        for more in range(3):  # also in the middle of a number, or of a message
            file.write_bytes(content[:round(len(content) * kept) + more])
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
