# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Calibration: measured drives become parameters."""

from math import degrees, pi
import signal

from hypothesis import given
from hypothesis import strategies as st
import pytest
import yaml

from create_oi_ros.apps.calibrate.calibration import (
    Calibration,
    EndOffset,
    line,
    Run,
    square,
    turns,
)
from create_oi_ros.apps.calibrate.create_calibrate import main
from create_oi_ros.apps.calibrate.listen import Tally
from create_oi_ros.driver import Settings
from create_oi_ros.odometry import Geometry
from create_oi_ros.ros.parameters import Parameters
from create_oi_ros.ros.programs import explained
from support.loop import Loop
from support.ros import scene
from support.source import ROOT

FACTORS = st.floats(0.9, 1.1)


def test_defaults_are_those_of_the_parameters():
    for name, value in vars(Calibration()).items():
        assert getattr(Parameters, name) == value


@given(FACTORS, st.lists(st.floats(0.5, 10), min_size=1, max_size=5))
def test_a_line_finds_the_scale(scale, lengths):
    runs = [Run(measured=length, reported=length / scale) for length in lengths]
    assert line(runs, Calibration()).linear_scale == pytest.approx(scale)


@given(FACTORS, FACTORS)
def test_a_correction_builds_on_the_old_value(first, second):
    once = line([Run(first, 1)], Calibration())
    assert line([Run(second, 1)], once).linear_scale == pytest.approx(first * second)


def test_turns_change_the_separation_the_other_way():
    found = turns([Run(3600, 3548), Run(-3600, -3551)], Calibration())
    assert found.angular_scale == pytest.approx(7200 / 7099)
    assert found.wheel_separation == pytest.approx(0.258 * 7099 / 7200)


def test_a_robot_with_closer_wheels_is_calibrated():
    """Turn ten times by odometry, compare with the truth, calibrate, and turn again."""
    def drive(calibration: Calibration) -> Run:
        loop = Loop(Settings(geometry=Geometry(
            wheel_separation=calibration.wheel_separation,
            linear_scale=calibration.linear_scale, angular_scale=calibration.angular_scale)),
            wheel_separation=0.25)
        loop.run(0.5)
        loop.drive(0.0, 1.0, 20.0)
        loop.run(2.0)
        return Run(degrees(loop.body.truth().turned), degrees(loop.estimate.yaw))
    first = drive(Calibration())
    assert first.reported != pytest.approx(first.measured, rel=0.01)
    found = turns([first], Calibration())
    assert found.wheel_separation == pytest.approx(0.25, rel=0.005)
    second = drive(found)
    assert second.reported == pytest.approx(second.measured, rel=0.005)


@given(st.floats(0.95, 1.05))
def test_a_square_finds_a_wrong_separation(share):
    """
    Ends for wheels `share` times as far apart as assumed, computed for small errors.

    Each corner turns by 90/share degrees instead of 90 (Borenstein and Feng, type A).
    """
    side, alpha = 2.0, pi / 2 - pi / 2 / share
    ends = [EndOffset(-2 * side * alpha, 0.0)]
    found = square(ends, ends, side, Calibration())
    assert found.calibration.wheel_separation == pytest.approx(0.258 * share, rel=0.002)
    assert found.wheel_ratio == pytest.approx(1.0)


def test_a_square_reports_unequal_wheels():
    found = square([EndOffset(0.1, 0)], [EndOffset(-0.1, 0)], 2.0, Calibration())
    assert found.calibration == Calibration()
    assert found.wheel_ratio != 1
    assert found.worst == pytest.approx(0.1)


@pytest.mark.parametrize('runs', [[Run(2, -2)], [Run(0, 1)], [Run(2, 0)], [Run(2000, 2)]])
def test_unbelievable_values_are_refused(runs):
    with pytest.raises(ValueError, match='measured|believable'):
        line(runs, Calibration())


def test_the_command_writes_a_file_that_ros_reads(tmp_path, capsys):
    path = tmp_path / 'create.yaml'
    assert main(['-o', str(path), 'line', '2.0:1.9']) == 0
    assert str(path) in capsys.readouterr().out
    parameters = yaml.safe_load(path.read_text())['/**']['ros__parameters']
    assert parameters['linear_scale'] == pytest.approx(2 / 1.9, abs=1e-5)
    assert set(parameters) <= set(Parameters.__dataclass_fields__)


@pytest.mark.parametrize('arguments', [
    ['line', 'nan:nan'], ['line', 'inf:inf'], ['line', '1:2:3'], ['turns', '-nan:1'],
    ['square', '--side', 'nan', '--clockwise', '0,0', '--counter', '0,0'],
    ['--linear-scale', 'nan', 'line', '2:2'], ['--wheel-separation', '-1', 'turns', '10:10'],
    ['--linear-scale', '0', 'line', '2:2'], ['line', '2:2', '--ros-args', '-r', '__ns:=/a'],
    ['line', '2.0'], ['turns'], ['square', '--side', '2', '--clockwise', '1'], []])
def test_the_command_explains_its_arguments(arguments, capsys):
    with pytest.raises(SystemExit):
        main(arguments)
    assert 'create_calibrate' in capsys.readouterr().err


def test_the_command_refuses_unbelievable_values(capsys):
    assert main(['line', '2000:2']) == 2
    assert 'same unit' in capsys.readouterr().err


SPIN = ['turns', '3600:3548', '-3600:-3551']
TURNED = {'angular_scale': 1.01423, 'wheel_separation': 0.25438}


def test_negative_values_are_no_options(capsys):
    assert main(SPIN) == 0
    assert yaml.safe_load(capsys.readouterr().out)['/**']['ros__parameters'] == TURNED
    assert main(['square', '--side', '2', '--clockwise', '-0.05,-0.02', '-.06,0',
                 '--counter', '-0.06,0.03']) == 0


@pytest.mark.parametrize(('before', 'after'), [
    ('', '/**:\n  ros__parameters:\n    angular_scale: 1.01423\n    wheel_separation: 0.25438\n'),
    ('# mine\n/create:\n  ros__parameters:\n    # the left port\n    port: "/dev/a"   # why\n'
     '    angular_scale: 2  # old\n',
     '# mine\n/create:\n  ros__parameters:\n    # the left port\n    wheel_separation: 0.25438\n'
     '    port: "/dev/a"   # why\n    angular_scale: 1.01423  # old\n'),
    ('create: {ros__parameters: {port: a}}\n',
     'create: {ros__parameters: {angular_scale: 1.01423, wheel_separation: 0.25438, port: a}}\n'),
    ('"/**": {ros__parameters: {}}\n',
     '"/**": {ros__parameters: {angular_scale: 1.01423, wheel_separation: 0.25438}}\n'),
    ('/camera:\n  ros__parameters:\n    fps: 3',
     '/camera:\n  ros__parameters:\n    fps: 3\n/**:\n  ros__parameters:\n'
     '    angular_scale: 1.01423\n    wheel_separation: 0.25438\n')])
def test_all_else_in_a_parameter_file_stays_as_it_is(tmp_path, before, after):
    path = tmp_path / 'create.yaml'
    path.write_text(before)
    assert main(['-o', str(path), *SPIN]) == 0
    assert path.read_text() == after


def test_the_shipped_file_keeps_its_comments(tmp_path):
    path = tmp_path / 'create.yaml'
    shipped = (ROOT / 'config' / 'create.yaml').read_text()
    path.write_text(shipped)
    expected = shipped.replace('angular_scale: 1.0\n', 'angular_scale: 1.01423\n').replace(
        'wheel_separation: 0.258\n', 'wheel_separation: 0.25438\n')
    assert main(['-o', str(path), *SPIN]) == 0
    assert path.read_text() == expected != shipped


@pytest.mark.parametrize(('content', 'reason'), [
    (b'a thesis\n', 'it is no ROS parameter file: it has no ros__parameters'),
    (b'- 1\n', 'no ros__parameters'), (b'a: [1\n', 'it is no ROS parameter file: while parsing'),
    (b'\xff\xfe\x00', 'it is no text'), (b'a: &a {b: *a}\n', 'no ros__parameters'),
    (b'/**:\n  ros__parameters:\n', 'no ros__parameters'),
    (b'r1/create: {ros__parameters: {a: 1}}\nr2/create: {ros__parameters: {a: 1}}\n',
     'several nodes that may be this robot (r1/create, r2/create)'),
    (b'{camera: {ros__parameters: {a: 1}}}\n', 'write into it: angular_scale: 1.01423, wheel')])
def test_another_file_is_left_alone(tmp_path, capsys, content, reason):
    path = tmp_path / 'thesis'
    path.write_bytes(content)
    assert main(['-o', str(path), *SPIN]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f'create_calibrate: {path} is left as it is: ') and reason in said
    assert said.count('\n') == 1 and path.read_bytes() == content


def test_a_file_that_cannot_be_written_gets_a_sentence(tmp_path):
    for path, why in ((tmp_path, 'this is a folder'), (tmp_path / 'no' / 'x', 'its folder does')):
        with pytest.raises(OSError) as error:
            main(['-o', str(path), *SPIN])
        assert explained(error.value).startswith(f'{path}: ') and why in explained(error.value)


def test_a_value_that_the_node_does_not_take_is_refused(capsys):
    assert main(['--wheel-separation', '0.5', 'turns', '10:11']) == 2
    assert 'wheel_separation would be 0.55000; the node takes 0.1 to 0.5' in (
        capsys.readouterr().err)
    assert main(['square', '--side', '2', '--clockwise', '50,0', '--counter', '-50,0']) == 2


def test_listen_says_that_nothing_comes_and_takes_a_namespace(tmp_path):
    with scene(tmp_path) as stage:
        listener = stage.program(
            'create_calibrate', 'listen', '--ros-args', '-r', '__ns:=/robot1')
        stage.ros.until(lambda: 'nothing on /robot1/odom yet   (Ctrl-C ends)\n' in listener.output)
        stage.node(stage.robot().link, '__ns:=/robot1')
        stage.ros.until(lambda: 'reported:   +0.000 m' in listener.output)
        listener.send(signal.SIGINT)
        assert listener.ended() == 0


def test_listen_without_a_driver_ends_with_a_sentence(tmp_path):
    with scene(tmp_path) as stage:
        listener = stage.program('create_calibrate', 'listen')
        stage.ros.until(lambda: 'nothing on /odom yet' in listener.output)
        listener.send(signal.SIGINT)
        assert listener.ended() == 1
        assert listener.printed[-1] == (
            'create_calibrate: nothing came on /odom: does a driver run in this ROS domain and '
            'namespace?\n')


def test_a_tally_counts_beyond_a_turn_and_back():
    tally = Tally()
    for step in range(1001):
        tally.add(step / 1000, 0.0, step / 1000 * 20, forward=True)
    assert tally.distance == pytest.approx(1.0)
    assert tally.turned == pytest.approx(20.0)
    for step in range(1000, -1, -1):
        tally.add(step / 1000, 0.0, step / 1000 * 20, forward=False)
    assert tally.distance == pytest.approx(0.0, abs=1e-9)
    assert tally.turned == pytest.approx(0.0, abs=1e-9)
