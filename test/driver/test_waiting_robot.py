# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A robot that waits for another reason than the driver's own script.

Whether it loses or queues what it is sent meanwhile is not known: both, and queues of many sizes.
"""

from dataclasses import replace

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Severity
from create_oi_ros.driver.outbox import DRAIN
from create_oi_ros.sim.firmware import Create
from support.loop import Loop, said

QUEUES = (0, 40, 135, 256, 330, 341, 342, 343, 344, 345, 360, 1000)
"""Sizes of the robot's queue; some are full in the middle of what the driver sends."""


def waiting(tenths: int, **guesses: object) -> Loop:
    """Return a robot that drives, and then waits as if damaged bytes had told it to."""
    loop = Loop()
    loop.robot.guesses = replace(loop.robot.guesses, **guesses)
    loop.run(0.5)
    loop.drive(0.2, 0.0, 1.0)
    loop.heard.clear()
    loop.robot.receive(oi.WaitTime(time=tenths).encode(), loop.now)
    assert loop.robot.waiting
    return loop


def without_drain(loop: Loop) -> int:
    """Count what the robot was sent but for the zeros that end a command: they harm nothing."""
    return len(loop.heard.replace(DRAIN, b''))


@pytest.mark.parametrize('queue', [0, 256])
def test_within_a_second_of_a_wait_less_is_sent_than_any_queue_holds(queue):
    loop = waiting(8, wait_queue=queue)
    loop.drive(0.3, 0.5, 0.8)
    assert len(loop.heard) < 135
    loop.drive(0.3, 0.0, 1.0)
    assert loop.body.truth().speed == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize('queue', [0, 135, 256, 1000])
@pytest.mark.parametrize('streams', [True, False])
def test_a_robot_that_waits_for_long_is_sent_little_and_drives_after_it(queue, streams):
    loop = waiting(100, wait_queue=queue, stream_while_waiting=streams)
    loop.drive(0.2, 1.0, 9.5)
    assert loop.robot.waiting
    assert without_drain(loop) < (200 if streams else 300)
    loop.drive(0.2, 0.0, 3.5)
    if not streams:  # it was away: commands have to pause
        loop.run(1.0)
        loop.drive(0.2, 0.0, 1.0)
    assert not loop.robot.waiting
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.body.truth().speed == pytest.approx(0.2, abs=0.01)
    assert not loop.driver.health(loop.now).suspects_commands


@pytest.mark.parametrize('queue', QUEUES)
@pytest.mark.parametrize('tenths', [5, 31, 32])
def test_no_part_of_what_is_sent_does_harm(queue, tenths):
    """A lost beginning of Stream would leave packet 7, which restarts the robot."""
    loop = waiting(tenths, wait_queue=queue)
    restarted = []
    loop.robot.power = lambda *_: restarted.append('power')
    fastest = 0.0
    while loop.robot.waiting:
        loop.drive(0.2, 0.0, 0.1)
    loop.driver.drive(0.0, 0.0, loop.now)
    for _ in range(400):
        loop.turn()
        fastest = max(fastest, abs(loop.body.truth().speed))
    assert not restarted
    assert loop.robot.mode is oi.Mode.SAFE
    assert fastest <= 0.21
    assert loop.body.truth().speed == 0


@pytest.mark.parametrize('queue', [0, 256])
def test_of_stops_while_the_robot_waits_two_are_sent_and_hold_after_it(queue):
    loop = waiting(20, wait_queue=queue)
    loop.drive(0.3, 0.0, 0.5)
    assert loop.driver.health(loop.now).suspects_commands
    before = bytes(loop.heard)
    for _ in range(20):
        loop.driver.stop(loop.now)
        loop.turn()
    assert bytes(loop.heard[len(before):]).count(b'\x91') == 2
    loop.run(3.0)
    assert not loop.robot.waiting
    assert loop.body.truth().speed == 0
    assert not loop.driver.health(loop.now).suspects_commands


def test_a_script_that_is_asked_for_meanwhile_comes_damaged_and_the_robot_drives_after_it():
    loop = waiting(12)
    loop.run(0.9)
    assert loop.driver.health(loop.now).suspects_commands
    shown = loop.driver.scripts.show(loop.now)
    loop.run(4.0)
    assert 'damaged' in shown.outcome.text
    loop.drive(0.2, 0.0, 1.0)
    assert loop.body.truth().speed == pytest.approx(0.2, abs=0.01)


def test_a_wait_from_before_the_driver_started_is_met():
    loop = Loop()
    loop.robot = Create(loop.body)
    loop.robot.receive(oi.Start().encode() + oi.WaitTime(time=30).encode(), loop.now)
    loop.run(2.5)
    assert not loop.driver.state.answered
    loop.run(2.0)
    assert loop.robot.mode is oi.Mode.SAFE
    loop.drive(0.2, 0.0, 0.5)
    assert loop.body.truth().speed > 0.1


def test_what_is_suspected_is_said_and_a_line_that_only_lost_a_speed_is_not_suspected():
    loop = waiting(40)
    loop.run(0.25)
    assert not loop.driver.health(loop.now).suspects_commands
    loop.run(1.5)
    assert loop.driver.health(loop.now).suspects_commands
    loop.run(0.5)
    assert said(loop, Severity.ERROR, 'ignores commands') == 1
