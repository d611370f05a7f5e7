# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The driver played against the simulated robot, byte for byte, without a clock."""

from math import pi

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Driver, Settings
from support.loop import Loop, turn_difference

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


def test_settings_that_are_not_given_are_those_of_the_documents():
    settings = Settings()
    assert (settings.baud, settings.odometry_window) == (57600, 1.0)
    assert (settings.mode_on_start, settings.mode_on_exit) == (oi.Mode.SAFE, oi.Mode.PASSIVE)
    assert (settings.recover_mode, settings.reset_when_not_charging) == (True, False)
    with pytest.raises(AttributeError):
        settings.baud = 19200


def test_the_list_of_packets_fits_the_slot_at_57600_baud():
    driver = Driver()
    for packets in driver.plan.lists:
        assert packets.budget(57600).fits


@pytest.mark.parametrize('checksum', list(oi.Checksum))
def test_either_checksum_is_understood(checksum):
    loop = Loop(checksum=checksum)
    loop.run(0.3)
    assert loop.driver.health(loop.now).checksum is checksum
    assert loop.driver.counts.checksum_failures == 0


def test_a_robot_that_drives_is_stopped_when_the_driver_connects():
    loop = Loop()
    loop.robot.receive(b''.join(command.encode() for command in (
        oi.Start(), oi.Full(), oi.DriveDirect(right=300, left=300))), loop.now)
    loop.run(1.5)
    assert loop.body.truth().speed == 0


def test_without_a_port_nothing_is_counted_and_a_stop_and_the_end_send_nothing():
    driver = Driver()
    assert set(vars(driver.counts).values()) == {0}
    assert driver.status.reason == 'no robot answers'
    assert driver.stop(0.0).outcome.ok is False
    driver.shut_down(0.1)
    assert driver.data_to_send() == b''


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


def test_a_driver_is_busy_until_its_commands_are_made_ready(loop):
    assert not loop.driver.busy
    loop.driver.modes.set(oi.Mode.FULL, loop.now)
    assert loop.driver.busy
    loop.run(0.3)
    assert not loop.driver.busy
