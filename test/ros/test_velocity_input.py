# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Velocity commands are read from their bytes as rclpy would read them."""

import struct

from geometry_msgs.msg import Twist
from hypothesis import given
from hypothesis import strategies as st
import pytest
from rclpy.serialization import serialize_message

from create_oi_ros.ros import velocity_input
from create_oi_ros.ros.velocity_input import TwistReader

SPEEDS = st.floats(allow_nan=False)


@pytest.fixture
def warnings() -> list[str]:
    """Return the warnings of a reader."""
    return []


@given(st.lists(SPEEDS, min_size=6, max_size=6))
def test_both_numbers_are_read(numbers):
    warnings: list[str] = []
    twist = Twist()
    (twist.linear.x, twist.linear.y, twist.linear.z,
     twist.angular.x, twist.angular.y, twist.angular.z) = numbers
    assert TwistReader(warnings.append)(serialize_message(twist)) == (numbers[0], numbers[5])
    assert warnings == []


def test_another_byte_order_is_read_too(warnings):
    big = bytes([0, 0, 0, 0]) + struct.pack('>6d', 0.1, 0.0, 0.0, 0.0, 0.0, -2.0)
    assert TwistReader(warnings.append)(big) == (0.1, -2.0)


def test_where_the_layout_is_not_certain_rclpy_converts_and_it_is_said(warnings, monkeypatch):
    def unknown(*_: object) -> None:
        raise ValueError('its place is not certain')
    monkeypatch.setattr(velocity_input, 'unpacking', unknown)
    twist = Twist()
    twist.linear.x, twist.angular.z = 0.3, -0.4
    assert TwistReader(warnings.append)(serialize_message(twist)) == (0.3, -0.4)
    assert len(warnings) == 1 and 'its place is not certain' in warnings[0]
