# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Commands that the robot did not hear, or misheard."""


import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Severity
from create_oi_ros.sim.firmware.actuators import DARK, Lights
from support.loop import Loop, said


@pytest.mark.parametrize('begun', [
    oi.Song(number=0, notes=(oi.Note(60, 10),) * 16).encode()[:3],
    oi.Script(script=bytes(100)).encode()[:2], bytes([oi.Stream.opcode, 255])])
def test_a_robot_in_the_middle_of_a_command_hears_a_stop_within_a_second(begun):
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    loop.robot.receive(begun, loop.now)
    loop.driver.stop(loop.now)
    loop.run(1.5)
    assert loop.body.truth().speed == 0
    assert loop.driver.state.answered


def test_a_robot_that_stands_and_waits_is_told_of_and_told_all_again_when_it_hears():
    loop = Loop()
    loop.run(1)
    pending = loop.driver.outputs.set_leds(
        oi.Leds(bits=oi.LedBits(0), color=7, intensity=8))
    loop.run(0.5)
    assert pending.outcome.ok
    loop.robot.receive(oi.WaitTime(time=40).encode(), loop.now)
    loop.run(3.5)
    assert said(loop, Severity.ERROR, 'ignores commands') == 1
    assert not loop.driver.stop(loop.now).outcome.ok
    loop.robot.actuators.lights = DARK
    loop.run(2.5)
    assert not loop.driver.health(loop.now).ignores_commands
    assert loop.robot.actuators.lights == Lights(oi.LedBits(0), 7, 8)
    assert loop.driver.stop(loop.now).outcome == (True, 'stop sent', b'')


def test_a_robot_that_was_told_to_wait_is_well_after_it_was_switched_off_and_on():
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    loop.robot.receive(oi.WaitEvent(event=oi.Event.PLAY_BUTTON).encode(), loop.now)
    loop.run(3.0)
    assert said(loop, Severity.ERROR, 'switch it off and on') == 1
    loop.robot.power(False, loop.now)
    loop.run(1.0)
    loop.robot.power(True, loop.now)
    loop.run(5.0)
    assert loop.robot.mode is oi.Mode.SAFE
    assert not loop.driver.health(loop.now).ignores_commands
    assert loop.body.truth().speed == 0


def test_a_robot_that_spoke_before_it_was_called_is_not_said_to_have_left_its_mode():
    loop = Loop(delay=0.03)
    loop.run(1)
    loop.driver.disconnected('cable out')
    loop.driver.connected(loop.now)
    loop.run(1)
    assert not said(loop, Severity.WARNING, 'robot left')
    assert loop.robot.mode is oi.Mode.SAFE
