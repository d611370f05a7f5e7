# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The file of what is known of a robot, and the node that keeps one."""

from dataclasses import replace
from math import nan
from pathlib import Path
import signal

from diagnostic_msgs.msg import DiagnosticArray
import pytest
from std_srvs.srv import Trigger
import yaml

from create_oi_ros.odometry import Geometry, Known, KnownGyro
from create_oi_ros.odometry.filters import Filters
from create_oi_ros.ros.odometry_model import (
    parsed,
    read,
    text_of,
    write,
    write_whole,
)
from support.ros import Ready


def anything() -> str:
    """Return the file of a robot of which nothing is known."""
    return text_of(Filters(Geometry(), None).knowledge(None))


def test_a_file_says_what_was_written(tmp_path):
    before = parsed(anything())
    assert read(tmp_path / 'model.yaml') is None
    write(tmp_path / 'model.yaml', before, {'banner': 'none'})
    after = read(tmp_path / 'model.yaml')
    assert after == before
    gyro = KnownGyro(Known(2.5, 0.001), Known(-79.123456789, 0.1))
    known = replace(before, gyro=gyro, readings=123, lag=Known(1 / 3, 1 / 7))
    assert parsed(text_of(known)) == known


def test_a_folder_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(ValueError, match='nowhere is no folder'):
        read(tmp_path / 'nowhere' / 'model.yaml')


@pytest.mark.parametrize(('change', 'said'), [
    ({'format': 4}, 'format 4 is not known'),
    ({'right_gain': {'value': 7.0, 'deviation': 0.1}}, 'right_gain: value is 7.0; allowed: 0.1'),
    ({'right_gain': {'value': nan, 'deviation': 0.1}}, 'right_gain: value is nan; allowed: 0.1'),
    ({'right_gain': {'value': 10 ** 400, 'deviation': 0.1}}, 'right_gain: value is 10000'),
    ({'right_gain': {'value': 'fast', 'deviation': 0.1}}, "'fast': a number is wanted"),
    ({'right_gain': {'value': 1.0, 'deviation': -1.0}}, 'right_gain: deviation is -1.0'),
    ({'right_gain': {'value': 1.0}}, 'right_gain: deviation is None'),
    ({'right_gain': 1.0}, 'right_gain must be a mapping'),
    ({'rounding': {'up': 1.0}}, "'up' is unknown; allowed: truncate, round, carry"),
    ({'rounding': {'carry': 0.5}}, 'rounding: the probabilities add up to 0.5, not to 1'),
    ({'encoder_sign': {'drive': 2.0}}, 'encoder_sign: drive is 2.0; allowed: 0 to 1'),
    ({'frame_period': {'value': 0.02, 'deviation': 1e-5}}, 'frame_period: value is 0.02'),
    ({'dead_time': None}, 'dead_time is missing'), ({'readings': -1}, 'readings is -1'),
    ({'gyro': {'zero': {'value': 2.5, 'deviation': 0.1}}}, 'gyro: scale is missing'),
    ({'gyros': {}}, "'gyros' is unknown; allowed: format, verdict, rounding, .*, gyro, readings"),
    *(({'gyro': {'zero': {'value': 2.5, 'deviation': 0.1},
                 'scale': {'value': scale, 'deviation': 0.1}}}, f'scale: value is {scale}')
      for scale in (0.5, -2000.0)),
])
def test_a_value_that_cannot_be_is_named(change, said):
    with pytest.raises(ValueError, match=said):
        parsed(yaml.safe_dump(yaml.safe_load(anything()) | change))


@pytest.mark.parametrize(('content', 'said'), [
    (b'', 'no model of a robot.*; delete the file'), (b'[1, 2', 'no YAML.*; delete the file'),
    (b'format: 3', 'rounding is missing.*; delete the file'),
    (b'just words', 'no model of a robot.*; delete the file'), (b'\xff\xfe\x00', 'is no text'),
    *((content, 'no YAML.*; delete the file') for content in (
        b'format: !!bool perhaps', b'format: !!timestamp today', b'[' * 3000, b'2026-99-99'))])
def test_what_is_no_model_is_named(tmp_path, content, said):
    file = tmp_path / 'model.yaml'
    file.write_bytes(content)
    with pytest.raises(ValueError, match=f'model.yaml.*{said}'):
        read(file)


def test_a_file_of_an_older_odometry_is_kept_aside_and_a_new_one_written_and_read(
        stage, tmp_path):
    file = tmp_path / 'model.yaml'
    file.write_text('format: 2\n')
    ready = Ready(stage, odometry_model=file)
    until, node = stage.ros.until, ready.node
    until(lambda: f'{file} does not exist: the odometry learns the robot' in node.output)
    assert f'format 2 is of an older odometry: it is kept as {file}.old' in node.output
    assert (tmp_path / 'model.yaml.old').read_text() == 'format: 2\n'
    assert not file.exists()
    stage.ros.drive(0.2, 0.0, lambda: ready.robot.body.truth().pose.x > 0.4)
    assert 'not known well yet' in ready.ask(Trigger, 'save_odometry_model')
    known = read(file)
    assert known is not None
    assert isinstance(known.right_gain, Known)
    node.send(signal.SIGINT)
    assert node.ended() == 0
    assert f'too little was learned of the robot: {file} is not written' in node.output
    diagnosed = stage.ros.listen(DiagnosticArray, '/diagnostics')
    again = stage.node(ready.robot.link, odometry_model=file)
    until(lambda: f'starts with what {file} knows' in again.output)
    until(lambda: [status for array in diagnosed for status in array.status
                   if status.name == 'create: odometry' and status.values])


def test_a_broken_file_or_a_home_of_nobody_keeps_the_node_from_starting(stage, tmp_path):
    file = tmp_path / 'model.yaml'
    file.write_text('format: 9\n')
    for model, words in ((file, f'{file}: format 9'),
                         ('~nobody-here/model.yaml', '~nobody-here is no folder')):
        node = stage.node(tmp_path / 'port', odometry_model=model)
        assert node.ended() == 2
        assert f'create_node: parameter odometry_model: {words}' in node.output
        assert 'Traceback' not in node.output


def test_a_file_is_replaced_by_its_link_too_and_keeps_its_permissions(tmp_path: Path) -> None:
    target, link = tmp_path / 'model.yaml', tmp_path / 'link'
    target.write_text('old')
    target.chmod(0o640)
    link.symlink_to(target)
    for path in (target, link):
        write_whole(path, path.name.encode())
        assert target.read_text() == path.name
        assert target.stat().st_mode & 0o777 == 0o640
    assert link.is_symlink()
    assert {*tmp_path.iterdir()} == {target, link}, 'nothing is left beside it'


@pytest.mark.parametrize('name', ['no/such/folder', '.'])
def test_what_cannot_be_written_is_an_error_that_names_it(tmp_path: Path, name: str) -> None:
    target = tmp_path / name
    with pytest.raises(OSError, match=str(target)) as error:
        write_whole(target, b'new')
    assert error.value.filename == str(target)
    assert list(tmp_path.iterdir()) == []
