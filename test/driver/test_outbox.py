# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which bytes leave when, and what stops a robot; times are binary fractions, so exact."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver.outbox import (
    DEAD_MAN_STOP,
    END_DEMO,
    farewell,
    LOST,
    MODE_PAUSE,
    Outbox,
    WAKE_UP,
)

HALT = oi.DriveDirect(right=0, left=0)
OFF = oi.LowSideDrivers(bits=oi.DriverBits(0))


def released(outbox: Outbox, now: float) -> bytes:
    """Return what leaves now."""
    outbox.release(now)
    return outbox.take_ready()


@pytest.mark.parametrize('mode', [oi.Start, oi.Safe, oi.Full])
def test_after_a_mode_the_robot_has_time_to_enter_it(mode: type[oi.Command]) -> None:
    assert MODE_PAUSE == 0.02
    outbox = Outbox()
    outbox.send(mode())
    outbox.send(OFF)
    assert released(outbox, 8.0) == mode().encode()
    assert released(outbox, 8.019) == b''
    assert outbox.busy
    assert released(outbox, 8.0201) == OFF.encode()


def test_a_stop_overtakes_all_that_waits() -> None:
    outbox = Outbox()
    outbox.send(oi.Safe())
    outbox.send(OFF)
    assert released(outbox, 8.0) == oi.Safe().encode()
    outbox.send_at_once(HALT, 8.001)
    assert released(outbox, 8.002) == HALT.encode()
    assert released(outbox, 8.019) == b'', 'the pause after the mode goes on'
    assert released(outbox, 8.021) == OFF.encode()


def test_what_was_not_written_is_lost_and_never_leaves() -> None:
    outbox = Outbox()
    written = outbox.send(OFF, 'off')
    outbox.release(8.0)
    outbox.confirm()
    ready, queued = outbox.send(oi.Safe(), 'safe'), outbox.send(OFF, 'off', rest=9.0)
    outbox.send(OFF)
    outbox.release(8.5)
    outbox.clear()
    assert written.outcome == (True, 'off')
    assert ready.outcome == queued.outcome == (False, LOST)
    assert not outbox.busy and released(outbox, 30.0) == b''
    outbox.confirm()
    outbox.send(oi.Safe())
    outbox.release(40.0)
    outbox.clear()
    outbox.send(OFF)
    assert released(outbox, 40.01) == OFF.encode(), 'another robot owes no pause'


def test_a_rest_goes_with_the_command_that_needs_it() -> None:
    outbox = Outbox()
    outbox.send(oi.Start())
    demo = outbox.send(oi.CoverAndDock(), rest=1.0)
    outbox.send(OFF)
    assert released(outbox, 8.0) == oi.Start().encode()
    assert released(outbox, 9.0) == b'', 'after the pause that the mode needs'
    outbox.send(oi.Safe())
    assert outbox.call_off_motion() and not demo.outcome.ok
    assert released(outbox, 9.0) == OFF.encode() + oi.Safe().encode()


# What stops a robot.


STOP = bytes([145, 0, 0, 0, 0])


def test_a_robot_is_stopped_twice_then_what_it_waits_for_is_ended_and_it_is_stopped_again():
    assert WAKE_UP == STOP + STOP + bytes(2 * 145) + STOP
    rest = STOP + bytes([144, 0, 0, 0, 128])
    assert DEAD_MAN_STOP == rest + bytes(2 * 145) + rest
    assert (HALT.encode(), END_DEMO.encode()) == (STOP, bytes([136, 255]))


@pytest.mark.parametrize(('mode', 'demo'), [
    (oi.Mode.PASSIVE, bytes([136, 255])), (oi.Mode.OFF, b''), (oi.Mode.SAFE, b''),
    (oi.Mode.FULL, b''), (None, b'')])
@pytest.mark.parametrize(('on_exit', 'opcode'), [
    (oi.Mode.PASSIVE, 128), (oi.Mode.SAFE, 131), (oi.Mode.FULL, 132)])
def test_a_driver_that_ends_stops_wheels_motors_demo_and_stream(mode, demo, on_exit, opcode):
    sent = b''.join(command.encode() for command in farewell(mode, on_exit))
    assert sent == STOP + bytes([144, 0, 0, 0]) + demo + bytes([150, 0, opcode])
