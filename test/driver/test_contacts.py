# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the robot has felt, as points around it."""

from math import hypot, pi

import pytest

from create_oi_ros import oi
from create_oi_ros.driver.contacts import Contacts, LEFT_BEHIND, OUTSIDE
from create_oi_ros.odometry import Estimate
from create_oi_ros.robot import BODY_RADIUS

HERE = Estimate(x=1.0, y=2.0, yaw=pi / 2)
FAR = BODY_RADIUS + OUTSIDE
QUIET = {'bumps_and_wheel_drops': 0, 'cliff_left': 0, 'cliff_front_left': 0,
         'cliff_front_right': 0, 'cliff_right': 0, 'virtual_wall': 0}
PERSISTENCE = 2.0


def frame(contacts: Contacts, at: Estimate = HERE, stamp: float = 0.0, **felt: int):
    """Take a frame in; return the points."""
    contacts.update(oi.Readings({**QUIET, **felt}), at, stamp, PERSISTENCE)
    return contacts.points(at)


@pytest.mark.parametrize(('felt', 'ahead', 'left'), [
    ({'bumps_and_wheel_drops': 2}, 1, 1), ({'bumps_and_wheel_drops': 1}, 1, -1),
    ({'bumps_and_wheel_drops': 3}, 1, 0), ({'cliff_left': 1}, 1, 1),
    ({'cliff_front_left': 1}, 1, 1), ({'cliff_front_right': 1}, 1, -1),
    ({'cliff_right': 1}, 1, -1), ({'virtual_wall': 1}, 1, 0)])
def test_each_sensor_has_a_point_just_outside_the_hull_on_its_side(felt, ahead, left):
    (x, y), = frame(Contacts(), **felt)
    assert hypot(x, y) == pytest.approx(FAR)
    assert x * ahead > 0
    assert y == pytest.approx(0, abs=1e-9) if left == 0 else y * left > 0


def test_nothing_felt_is_no_point():
    assert frame(Contacts()) == ()
    assert frame(Contacts(), bumps_and_wheel_drops=4 + 8 + 16) == ()
    assert Contacts().points(HERE) == ()


def test_what_is_still_felt_does_not_end():
    contacts = Contacts()
    for stamp in range(10):
        assert len(frame(contacts, stamp=float(stamp), cliff_left=1)) == 1


def test_a_robot_that_moves_away_leaves_the_hit_where_it_was():
    contacts = Contacts()
    frame(contacts, bumps_and_wheel_drops=3)
    back = HERE._replace(y=HERE.y - 0.05)
    (x, y), = frame(contacts, back, 0.5)
    assert (x, y) == pytest.approx((FAR + 0.05, 0.0))
    (x, y), = frame(contacts, back._replace(yaw=pi), 1.0)
    assert (x, y) == pytest.approx((0.0, -FAR - 0.05))
    assert frame(contacts, HERE._replace(y=HERE.y - LEFT_BEHIND - 0.01), 1.1) == ()


def test_a_bump_straight_ahead_replaces_the_half_that_came_first():
    contacts = Contacts()
    frame(contacts, bumps_and_wheel_drops=2)
    (_, y), = frame(contacts, stamp=0.015, bumps_and_wheel_drops=3)
    assert y == pytest.approx(0, abs=1e-9)


def test_frames_that_lack_a_sensor_say_nothing_of_it():
    contacts = Contacts()
    contacts.update(oi.Readings({'bumps_and_wheel_drops': 1}), HERE, 0.0, PERSISTENCE)
    assert len(contacts.points(HERE)) == 1


def test_both_halves_of_the_bumper_have_points_at_the_same_angle():
    (ahead, left), (also_ahead, right) = (
        frame(Contacts(), bumps_and_wheel_drops=half)[0] for half in (2, 1))
    assert (ahead, left) == pytest.approx((also_ahead, -right))
