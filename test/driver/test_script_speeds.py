# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which packets tell the wheel speeds of a script, and how fast they say the wheels run."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver.script import ScriptSpeeds
from create_oi_ros.oi.script import build_script

DIRECT = oi.DriveDirect(right=100, left=-100)
DRIVE = oi.Drive(velocity=200, radius=oi.Radius.STRAIGHT)
REPORTED = {'requested_right_velocity': 300, 'requested_left_velocity': -150,
            'requested_velocity': 200, 'requested_radius': 500}


def speeds(*commands: oi.Command, cleared: bool = True) -> ScriptSpeeds:
    """Return what follows a script of these commands."""
    return ScriptSpeeds(build_script(commands), 0.25, cleared=cleared)


def test_a_script_of_one_kind_of_drive_is_followed_by_its_packets():
    assert speeds(DIRECT).speeds(oi.Readings(REPORTED)) == (0.3, -0.15)
    right, left = speeds(DRIVE).speeds(oi.Readings(REPORTED))
    assert (right, left) == pytest.approx((0.25, 0.15))  # 125 mm beside the middle, of 500


@pytest.mark.parametrize(('commands', 'known'), [
    ((DIRECT,), True), ((DRIVE,), True), ((), True), ((DRIVE, DIRECT), False),
    ((DRIVE, oi.Script(script=b'')), False)])
def test_speeds_are_known_of_a_script_that_uses_one_kind_of_drive(commands, known):
    assert speeds(*commands).known == known
    assert not speeds(*commands, cleared=False).known
    assert not ScriptSpeeds(None, 0.25, cleared=True).known


@pytest.mark.parametrize(('commands', 'resets'), [
    ((DRIVE, oi.WaitDistance(distance=9)), True), ((DIRECT, oi.WaitAngle(angle=9)), True),
    ((DRIVE, oi.WaitTime(time=9)), False), ((DRIVE, DIRECT, oi.WaitAngle(angle=9)), False)])
def test_waits_for_a_way_reset_what_is_counted(commands, resets):
    assert speeds(*commands).resets_accumulators == resets


def test_a_speed_that_the_robot_reports_oddly_is_not_known():
    assert speeds(DRIVE).speeds(oi.Readings({**REPORTED, 'requested_velocity': None})) is None
