# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The bytes that stop a robot, as numbers."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver.outbox import DEAD_MAN_STOP, END_DEMO, farewell, HALT, WAKE_UP

STOP = bytes([145, 0, 0, 0, 0])
LONGEST = 2 * 145
"""Bytes that a Song takes which takes the stop's opcode for its count of notes."""


def test_a_robot_is_stopped_twice_then_what_it_waits_for_is_ended_and_it_is_stopped_again():
    assert WAKE_UP == STOP + STOP + bytes(LONGEST) + STOP
    assert DEAD_MAN_STOP == STOP + b'\x80' + bytes(LONGEST) + STOP + b'\x80'
    assert (HALT.encode(), END_DEMO.encode()) == (STOP, bytes([136, 255]))


@pytest.mark.parametrize(('mode', 'demo'), [
    (oi.Mode.PASSIVE, bytes([136, 255])), (oi.Mode.OFF, b''), (oi.Mode.SAFE, b''),
    (oi.Mode.FULL, b''), (None, b'')])
@pytest.mark.parametrize(('on_exit', 'opcode'), [
    (oi.Mode.PASSIVE, 128), (oi.Mode.SAFE, 131), (oi.Mode.FULL, 132)])
def test_a_driver_that_ends_stops_wheels_motors_demo_and_stream(mode, demo, on_exit, opcode):
    sent = b''.join(command.encode() for command in farewell(mode, on_exit))
    assert sent == STOP + bytes([144, 0, 0, 0]) + demo + bytes([150, 0, opcode])
