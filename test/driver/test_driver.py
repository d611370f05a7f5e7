# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The driver played against the simulated robot, byte for byte, without a clock."""

from math import inf, nan, pi

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Driver, MotionLimits, Settings, Severity, wheel_speeds
from create_oi_ros.driver.stopping import DRAIN
from support.loop import Loop, texts, turn_difference

TIMEOUT = MotionLimits.timeout


# Connecting.


def test_connecting_sends_start_then_safe_then_streams():
    loop = Loop()
    loop.run(0.3)
    sent = loop.commands()
    kinds = [type(command) for command in sent]
    assert kinds.index(oi.Start) < kinds.index(oi.Safe)
    assert oi.Stream in kinds
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.driver.state.answered


@pytest.mark.parametrize('mode', [oi.Mode.PASSIVE, oi.Mode.SAFE, oi.Mode.FULL])
def test_mode_on_start_is_entered(mode):
    loop = Loop(Settings(mode_on_start=mode))
    loop.run(0.3)
    assert loop.robot.mode is mode


def test_the_list_of_packets_fits_the_slot_at_57600_baud():
    driver = Driver()
    for packets in driver.plan.lists:
        assert packets.budget(57600).fits


def test_at_19200_baud_every_list_fits_and_all_readings_come():
    loop = Loop(Settings(baud=19200))
    loop.run(3)
    for packets in loop.driver.plan.lists:
        assert packets.budget(19200).fits
    assert loop.moved[-1].readings.has('voltage', 'analog_signal', 'oi_mode')


@pytest.mark.parametrize('checksum', list(oi.Checksum))
def test_either_checksum_is_understood(checksum):
    loop = Loop(checksum=checksum)
    loop.run(0.3)
    assert loop.driver.health(loop.now).checksum is checksum
    assert loop.driver.counts.checksum_failures == 0


@pytest.mark.parametrize('command', oi.COMMANDS, ids=lambda command: command.title)
def test_a_command_cut_short_is_drained_and_moves_nothing(command):
    """Whatever byte of whatever command the robot has last heard, it wakes up."""
    if command.title in ('Wait Time', 'Wait Distance', 'Wait Angle', 'Wait Event'):
        pytest.skip('a robot that waits hears nothing (manual: Wait Commands)')
    longest = [100] * 300
    for length in range(1, command.size(bytes([command.opcode]))):
        loop = Loop()
        loop.robot.receive(oi.Start().encode() + oi.Full().encode(), loop.now)
        loop.robot.receive(bytes([command.opcode, *longest[:length - 1]]), loop.now)
        # A Query List of 255 packets is answered for more than a second.
        loop.run(2.0)
        assert loop.robot.mode is oi.Mode.SAFE, length
        assert loop.robot.baud == 57600
        assert loop.driver.state.answered
        loop.run(0.5)
        assert loop.body.truth().speed == 0


def test_drain_holds_no_opcode():
    assert not set(DRAIN) & set(oi.Command.by_opcode)


def test_a_robot_that_drives_is_stopped_when_the_driver_connects():
    loop = Loop()
    loop.robot.receive(b''.join(command.encode() for command in (
        oi.Start(), oi.Full(), oi.DriveDirect(right=300, left=300))), loop.now)
    loop.run(1.5)
    assert loop.body.truth().speed == 0


# Driving.


def test_a_velocity_becomes_drive_direct_right_wheel_first(at_once):
    loop = at_once
    loop.driver.drive(0.2, 1.0, loop.now)
    loop.run(0.05)
    assert loop.commands() == [oi.DriveDirect(right=329, left=71)]


def test_an_unchanged_velocity_is_sent_once(at_once):
    loop = at_once
    loop.drive(0.1, 0.0, 1.0)
    driven = [command for command in loop.commands() if isinstance(command, oi.DriveDirect)]
    assert driven == [oi.DriveDirect(right=100, left=100)]


def test_commands_faster_than_the_robot_listens_are_thinned_and_the_newest_wins(loop):
    for step in range(1, 101):
        loop.driver.drive(step / 1000, 0.0, loop.now)
        loop.turn()
    loop.run(0.05)
    sent = loop.commands()
    assert sent[-1] == oi.DriveDirect(right=100, left=100)
    assert len(sent) <= 100 * 0.005 / oi.SLOT + 2


def drives(loop):
    """Return what the robot was told of its wheels since the last time."""
    return [command for command in loop.commands() if isinstance(command, oi.DriveDirect)]


def test_a_command_before_the_robot_answers_moves_nothing_later():
    loop = Loop()
    loop.cut = True
    loop.run(1.0)
    loop.driver.drive(0.2, 0.0, loop.now)
    loop.cut = False
    loop.run(0.4)
    assert loop.driver.state.answered
    assert loop.body.truth().speed == 0
    assert not texts(loop.notices, Severity.WARNING)


def test_without_a_port_a_stop_and_the_end_send_nothing():
    driver = Driver()
    assert driver.status.reason == 'no robot answers'
    assert driver.stop(0.0).outcome.ok is False
    driver.shut_down(0.1)
    assert driver.data_to_send() == b''


def test_the_wheels_stop_when_commands_stop(at_once):
    loop = at_once
    loop.driver.drive(0.2, 0.0, loop.now)
    loop.run(TIMEOUT - 0.01)
    assert drives(loop) == [oi.DriveDirect(right=200, left=200)]
    loop.run(0.03)
    assert drives(loop) == [oi.DriveDirect(right=0, left=0)]


def test_stop_stops_at_once(loop):
    loop.drive(0.2, 0.0, 0.2)
    loop.commands()
    assert loop.driver.stop(loop.now).outcome.ok
    loop.turn()
    assert loop.commands()[0] == oi.DriveDirect(right=0, left=0)


@pytest.mark.parametrize('velocity', [(nan, 0.0), (0.1, nan), (inf, 0.0), (0.0, -inf)])
def test_a_velocity_that_is_not_finite_is_refused_and_stops(loop, velocity):
    loop.drive(0.2, 0.0, 0.2)
    loop.commands()
    loop.driver.drive(*velocity, loop.now)
    loop.run(0.05)
    assert loop.commands() == [oi.DriveDirect(right=0, left=0)]
    assert 'not finite' in texts(loop.notices, Severity.WARNING)[-1]


def test_velocities_that_are_not_finite_are_reported_once_and_counted(loop):
    for _ in range(50):
        loop.driver.drive(nan, 0.0, loop.now)
        loop.turn()
    assert len(texts(loop.notices, Severity.WARNING)) == 1
    loop.drive(0.1, 0.0, 0.1)
    assert texts(loop.notices, Severity.WARNING)[1:] == [
        'velocities are finite again; 49 more were not']


@given(st.floats(-3, 3), st.floats(-20, 20))
def test_limits_keep_the_curve(linear, angular):
    limits = MotionLimits()
    right, left = wheel_speeds(linear, angular, limits)
    assert max(abs(right), abs(left)) <= 500 + 1e-9
    free = MotionLimits(max_wheel_speed=1e9)
    free_right, free_left = wheel_speeds(linear, angular, free)
    fastest = max(abs(free_right), abs(free_left))
    scale = min(1.0, 500 / fastest) if fastest else 1.0
    assert right == pytest.approx(free_right * scale, abs=1.0)
    assert left == pytest.approx(free_left * scale, abs=1.0)


def test_limits_may_change_while_the_robot_drives(loop):
    loop.drive(0.2, 0.0, 0.5)
    loop.driver.set_limits(MotionLimits(max_wheel_speed=0.1))
    loop.drive(0.2, 0.0, 0.5)
    sent = [command for command in loop.commands() if isinstance(command, oi.DriveDirect)]
    assert sent[-1] == oi.DriveDirect(right=100, left=100)


def test_the_odometry_starts_again_where_the_robot_is(loop):
    loop.drive(0.2, 0.0, 2.0)
    assert loop.estimate.x > 0.2
    assert loop.driver.reset_odometry().outcome.ok
    loop.run(0.1)
    assert abs(loop.estimate.x) < 0.1


def test_a_metre_and_a_turn_agree_with_the_truth(loop):
    loop.drive(0.2, 0.0, 5.0)
    loop.run(1.0)
    loop.drive(0.0, 1.0, 2 * pi)
    loop.run(1.0)
    truth = loop.body.truth()
    assert truth.pose.x == pytest.approx(1.1, abs=0.05)
    assert loop.estimate.x == pytest.approx(truth.pose.x, abs=0.01)
    assert loop.estimate.y == pytest.approx(truth.pose.y, abs=0.01)
    assert turn_difference(loop.estimate.yaw, truth.pose.yaw) < 0.03


def requested(loop: Loop) -> list[oi.DriveDirect]:
    """Return the drives that the robot was sent since the last call."""
    return [command for command in loop.commands() if isinstance(command, oi.DriveDirect)]


@pytest.mark.parametrize('acceleration', [0.01, 0.5])
def test_acceleration_is_limited_up_and_down_and_the_curve_is_kept(acceleration):
    loop = Loop(Settings(limits=MotionLimits(linear_acceleration=acceleration)))
    loop.run(0.3)
    requested(loop)
    loop.drive(0.2, 0.4, 0.3)
    sent = requested(loop)
    assert sent[-1].right + sent[-1].left == pytest.approx(2000 * acceleration * 0.3, abs=20)
    for each in sent[len(sent) // 2:]:
        assert each.right == pytest.approx(each.left * 251.6 / 148.4, abs=1.5)
    loop.drive(0.2, 0.4, 0.3)
    loop.drive(0.0, 0.0, 0.1)
    assert requested(loop)[-1].right > 0


def test_turning_acceleration_is_limited():
    loop = Loop(Settings(limits=MotionLimits(angular_acceleration=1.0)))
    loop.run(0.3)
    requested(loop)
    loop.drive(0.0, 2.0, 0.5)
    last = requested(loop)[-1]
    assert (last.right - last.left) / 258 == pytest.approx(0.5, abs=0.05)


def test_stop_and_the_end_of_commands_know_no_acceleration_limit():
    loop = Loop(Settings(limits=MotionLimits(linear_acceleration=0.2)))
    loop.run(0.3)
    for end in (lambda: loop.driver.stop(loop.now), lambda: loop.run(TIMEOUT)):
        loop.drive(0.2, 0.0, 0.5)
        assert requested(loop)[-1].right > 50
        end()
        loop.run(0.02)
        assert requested(loop)[-1] == oi.DriveDirect(right=0, left=0)
