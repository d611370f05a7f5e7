# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""When a robot is called, to the hundredth of a second, and with which bytes."""

import pytest

from create_oi_ros.driver import Activity, Driver, Settings, Severity
from create_oi_ros.driver.outbox import HALT, WAKE_UP
from create_oi_ros.oi import Start, Stream
from support.typed_frames import answered, BEGIN, called, heard, LAST, notices, polled

KNOCK = Stream(packets=['oi_mode']).encode()
"""What a robot is sent that may only wait."""


def test_a_robot_that_does_not_answer_is_called_every_three_tenths_of_a_second():
    driver = called()
    polled(driver, BEGIN + 0.1)
    assert not any(polled(driver, BEGIN + after) for after in (0.2, 0.29))
    assert polled(driver, BEGIN + 0.31) == Start().encode()
    assert polled(driver, BEGIN + 0.34) == KNOCK
    assert not any(polled(driver, BEGIN + after) for after in (0.4, 0.6))
    assert notices(driver) == []
    assert polled(driver, BEGIN + 0.62).startswith(WAKE_UP)
    polled(driver, BEGIN + 0.93)
    (severity, text), = notices(driver)
    assert severity is Severity.ERROR and text.startswith('no answer at 57600 baud')
    assert driver.counts.silences == 0


def test_half_a_second_without_a_frame_is_silence():
    driver = answered()
    polled(driver, LAST + 0.25, LAST + 0.49)
    assert driver.state.answered
    assert polled(driver, LAST + 0.51) == HALT.encode() + KNOCK
    assert driver.state.activity is Activity.CALLING
    assert driver.counts.silences == 1
    (severity, text), = notices(driver)
    assert severity is Severity.ERROR
    assert text == ('no frame for 0.5 s: the robot is off, asleep or unplugged; calling it until '
                    'it answers')
    assert driver.health(LAST + 0.51).line_problem == text
    assert driver.health(LAST + 0.51).frame_age == 0.0


def test_after_a_standstill_the_wheels_are_stopped_and_the_robot_is_called():
    driver = answered()
    now = LAST + 1.01
    heard(driver, now)
    (severity, text), = notices(driver)
    assert severity is Severity.WARNING
    assert text.startswith('the driver stood still for 1.0 s (Ctrl-Z, a debugger, ')
    assert driver.state.activity is Activity.CALLING
    assert polled(driver, now) == HALT.encode()
    heard(driver, now + 0.049)  # an old frame
    assert polled(driver, now + 0.049) == b''
    assert driver.state.activity is Activity.CALLING
    assert polled(driver, now + 0.051) == HALT.encode() + KNOCK
    heard(driver, now + 0.06)
    assert driver.state.answered


@pytest.mark.parametrize(('baud', 'slow'), [(9600, 1), (19200, 0)])
def test_a_rate_that_is_too_slow_is_said_once(baud, slow):
    driver = Driver(Settings(baud=baud))
    for _ in range(3):
        driver.connected(BEGIN)
        driver.disconnected('cable out')
    assert sum(f'{baud} baud is too slow' in text for _, text in notices(driver)) == slow


def test_a_driver_that_ends_stops_the_robot_and_says_no_more():
    driver = answered()
    driver.shut_down(LAST + 0.1)
    assert driver.data_to_send() == (
        HALT.encode() + bytes([144, 0, 0, 0]) + bytes([150, 0]) + bytes([128]))
    assert driver.state.activity is Activity.CLOSED
    driver.shut_down(LAST + 0.2)
    assert polled(driver, LAST + 9.0) == b''
