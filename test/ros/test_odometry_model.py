# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The file of what is known of a robot, and the node that keeps one."""

import signal

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, Vector3
import pytest
from std_srvs.srv import Trigger
import yaml

from create_oi_ros.odometry import Family, Known, Odometry
from create_oi_ros.odometry.knowledge import learned
from create_oi_ros.ros.odometry_model import parsed, read, text_of, write
from support.ros import Scene


def anything() -> str:
    """Return the file of a robot of which nothing is known."""
    tracks = Odometry(window=1.0).tracks
    return text_of(learned(tracks.rows, tracks.band))


def test_a_file_says_what_was_written(tmp_path):
    before = parsed(anything())
    write(tmp_path / 'model.yaml', before, {'banner': 'none'})
    after = read(tmp_path / 'model.yaml')
    assert after is not None
    assert after.rounding == pytest.approx(before.rounding)
    assert after.encoder_sign == pytest.approx(before.encoder_sign)
    assert after.response == pytest.approx(before.response)
    for name in (*before.numbers, 'frame_period'):
        assert getattr(after, name) == pytest.approx(getattr(before, name))
    assert after.dead_band == pytest.approx(before.dead_band)
    for row, other in zip(after.correlations, before.correlations, strict=True):
        assert row == pytest.approx(other, abs=1e-6)


def test_an_odometry_that_starts_with_a_file_knows_what_it_says():
    model = yaml.safe_load(anything())
    model['right_gain'] = {'value': 1.03, 'deviation': 0.001}
    model['rounding'] = {'truncate': 0.0, 'round': 1.0, 'carry': 0.0}
    tracks = Odometry(window=1.0, robot=parsed(yaml.safe_dump(model))).tracks
    known = learned(tracks.rows, tracks.band)
    assert known.right_gain.value == pytest.approx(1.03, abs=1e-3)
    assert known.likeliest[0].value == 'round'


def spring() -> dict:
    """Return the content of a file of wheels that overshoot."""
    model = yaml.safe_load(anything())
    del model['inverse_acceleration']
    return model | {'response': {'lag': 0.1, 'spring': 0.9},
                    'damping': {'value': 0.4, 'deviation': 0.01}}


def test_wheels_that_overshoot_have_a_damping_instead_of_a_limited_acceleration():
    known = parsed(yaml.safe_dump(spring()))
    assert known.family is Family.SPRING
    assert known.inverse_acceleration is None
    assert known.overshoot == pytest.approx(0.254, abs=0.001)
    tracks = Odometry(window=1.0, robot=known).tracks
    assert tracks.rows.springs[:15].all()
    again = parsed(text_of(learned(tracks.rows, tracks.band)))
    assert again.damping is not None
    assert again.damping.value == pytest.approx(0.4, abs=1e-3)
    assert again.damping.deviation == pytest.approx(0.015, rel=0.1)  # it may have changed
    assert again.response[Family.SPRING] > 0.99


def test_a_file_from_before_wheels_could_overshoot_is_read():
    model = yaml.safe_load(anything())
    del model['response']
    known = parsed(yaml.safe_dump(model))
    assert known.response == {Family.LAG: 1.0}
    assert known.damping is None


@pytest.mark.parametrize(('change', 'said'), [
    ({'damping': {'value': 1.5, 'deviation': 0.1}}, 'value is 1.5; allowed: 0.15 to 0.95'),
    ({'response': {'ramp': 1.0}}, "'ramp' is unknown; allowed: lag, spring"),
    ({'response': {'lag': 1.0}}, 'inverse_acceleration is missing')])
def test_what_wheels_that_overshoot_cannot_have_is_named(change, said):
    with pytest.raises(ValueError, match=said):
        parsed(yaml.safe_dump(spring() | change))


def test_no_file_yet_is_no_fault(tmp_path):
    assert read(tmp_path / 'model.yaml') is None


def test_a_folder_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(ValueError, match='nowhere is no folder'):
        read(tmp_path / 'nowhere' / 'model.yaml')


@pytest.mark.parametrize(('change', 'said'), [
    ({'format': 2}, 'format 2 is not known'),
    ({'right_gain': {'value': 7.0, 'deviation': 0.1}}, 'right_gain: value is 7.0; allowed: 0.6'),
    ({'right_gain': {'value': 'fast', 'deviation': 0.1}}, "'fast': a number is wanted"),
    ({'right_gain': {'value': 1.0, 'deviation': 0.0}}, 'right_gain: deviation is 0.0'),
    ({'right_gain': 1.0}, 'right_gain must be a mapping'),
    ({'rounding': {'up': 1.0}}, "'up' is unknown; allowed: truncate, round, carry"),
    ({'rounding': {'carry': 0.0}}, 'no probability is above 0'),
    ({'dead_band': {'stands': 0.02, 'moves': 0.01}}, 'must be below moves'),
    ({'frame_period': {'value': 0.02, 'deviation': 1e-5}}, 'frame_period: value is 0.02'),
    ({'correlations': [[0.0]]}, 'correlations must be 10 rows'),
])
def test_a_value_that_cannot_be_is_named(change, said):
    with pytest.raises(ValueError, match=said):
        parsed(yaml.safe_dump(yaml.safe_load(anything()) | change))


@pytest.mark.parametrize(('text', 'said'), [
    ('', 'no model of a robot'), ('[1, 2', 'no YAML'), ('format: 1', 'is missing'),
    ('just words', 'no model of a robot')])
def test_what_is_no_model_is_named(tmp_path, text, said):
    file = tmp_path / 'model.yaml'
    file.write_text(text)
    with pytest.raises(ValueError, match=f'model.yaml: .*{said}.*; delete the file'):
        read(file)


def test_what_is_no_text_is_named(tmp_path):
    file = tmp_path / 'model.yaml'
    file.write_bytes(b'\xff\xfe\x00')
    with pytest.raises(ValueError, match='is no text'):
        read(file)


def drive(stage: Scene, metres: float, robot) -> None:
    """Drive straight ahead."""
    velocity = stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    timer = stage.ros.node.create_timer(
        0.1, lambda: velocity.publish(Twist(linear=Vector3(x=0.2))))
    stage.ros.until(lambda: robot.body.truth().pose.x > metres)
    stage.ros.node.destroy_timer(timer)
    velocity.publish(Twist())


def test_a_node_writes_what_it_learned_on_request(stage, tmp_path):
    robot, file = stage.robot(), tmp_path / 'model.yaml'
    node = stage.node(robot.link, odometry_model=file)
    stage.ros.until(lambda: 'does not exist: the odometry learns the robot' in node.output)
    drive(stage, 0.4, robot)
    answer = stage.ros.call(Trigger, 'save_odometry_model')
    assert answer.success, answer.message
    assert 'not known well yet' in answer.message
    known = read(file)
    assert known is not None
    assert isinstance(known.right_gain, Known)
    node.send(signal.SIGINT)
    assert node.ended() == 0
    assert 'stays as it is' in node.output


def test_a_node_starts_with_what_a_file_knows(stage, tmp_path):
    robot, file = stage.robot(), tmp_path / 'model.yaml'
    write(file, parsed(anything()))
    node = stage.node(robot.link, odometry_model=file)
    diagnosed = stage.ros.listen(DiagnosticArray, '/diagnostics')
    stage.ros.until(lambda: f'starts with what {file} knows' in node.output)
    drive(stage, 0.2, robot)
    stage.ros.until(lambda: [status for array in diagnosed for status in array.status
                             if status.name == 'create: odometry' and status.values])


def test_without_the_parameter_nothing_is_written(stage):
    robot = stage.robot()
    stage.node(robot.link)
    answer = stage.ros.call(Trigger, 'save_odometry_model')
    assert not answer.success
    assert '-p odometry_model:=FILE' in answer.message


def test_a_broken_file_keeps_the_node_from_starting(stage, tmp_path):
    file = tmp_path / 'model.yaml'
    file.write_text('format: 9\n')
    node = stage.node(tmp_path / 'port', odometry_model=file)
    assert node.ended() == 2
    assert f'create_node: parameter odometry_model: {file}: format 9' in node.output
    assert 'Traceback' not in node.output
