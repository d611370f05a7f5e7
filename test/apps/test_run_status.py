# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The status line of `create_run`: what it shows, and that it fits."""

from math import nan, pi

from create_oi_msgs.msg import Bumper, Mode
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
import pytest
from sensor_msgs.msg import BatteryState

from create_oi_ros.apps.run import RobotStatus, WIDTH
from create_oi_ros.ros.messages import of_yaw

PORT = '/dev/serial/by-id/usb-FTDI_FT232R_USB_UART_A50285BI-if00-port0'
ANY = st.floats(-1e9, 1e9) | st.just(nan)


def driving(x: float = 1.0, yaw: float = 0.0) -> RobotStatus:
    """Return the status of a robot in SAFE that drives."""
    status = RobotStatus()
    odom = Odometry()
    odom.pose.pose.position.x = x
    odom.twist.twist.linear.x = 0.2
    rotation = odom.pose.pose.orientation
    rotation.z, rotation.w = of_yaw(yaw)
    status.take(odom)
    status.take(Mode(mode=Mode.SAFE, wanted=Mode.SAFE))
    status.take(BatteryState(percentage=0.9))
    return status


def diagnostics(about: str, level: bytes, message: str) -> DiagnosticArray:
    """Return the diagnostics of a driver with one status."""
    return DiagnosticArray(status=[
        DiagnosticStatus(name=f'create: {about}', level=level, message=message)])


def test_the_usual_line_counts_frames_anew_each_second():
    status = driving()
    assert status.line() == (
        ' 1 frames/s  SAFE     x +1.00 y +0.00 m    +0 deg  90%  +0.20 m/s  +0.00 rad/s')
    assert status.line().startswith(' 0 frames/s')
    assert RobotStatus().line() == ' 0 frames/s  no node yet'
    assert ' -170 deg' in driving(yaw=190 * pi / 180).line(), 'within half a turn'


def test_a_script_is_shown_with_the_time_that_it_takes():
    status = driving()
    status.take(diagnostics('driver', DiagnosticStatus.OK, 'driving'))
    assert 'driving' not in status.line()
    status.take(diagnostics('driver', DiagnosticStatus.WARN, (
        'a script plays, and the robot ignores everything while it waits, a stop included: let '
        'it end, or switch the robot off by its Power button (it plays for about 3 s more)')))
    assert status.line() == (
        'SAFE  x +1.00 y +0.00 m    +0 deg  a script plays (it plays for about 3 s more)')


def test_a_short_bump_is_shown_once_and_a_long_one_until_it_ends():
    status = driving()
    status.take(Bumper(left=True))
    status.take(Bumper())
    assert 'BUMP left  ' in status.line()
    assert 'BUMP' not in status.line()
    status.take(Bumper(left=True, right=True))
    assert [('BUMP left and right' in status.line()) for _ in range(2)] == [True, True]
    status.take(Bumper())
    status.line()
    assert 'BUMP' not in status.line()


def test_the_reason_of_a_mode_is_shown_alone():
    status = driving()
    status.take(Mode(mode=Mode.UNKNOWN, wanted=Mode.SAFE, reason='no robot answers'))
    status.take(diagnostics('driver', DiagnosticStatus.WARN, 'no answer yet'))
    assert 'no robot answers' in status.line()
    assert 'no answer yet' not in status.line()


@pytest.mark.parametrize(('message', 'shown'), [
    (f'{PORT} does not exist; there are /dev/ttyUSB1: is the cable in?',
     'port does not exist; there are /dev/ttyUSB1: is the ca'),
    (f'{PORT}: no permission; `sudo usermod -aG dialout ada`, then log in again',
     'port: no permission; `sudo usermod -aG dialout ada`, t'),
    ("no answer at 57600 baud: is the robot on (Power light)? is it the Create's own",
     'no answer at 57600 baud: is the robot on (Power light)'),
])
def test_why_no_robot_answers_is_shown_until_one_does(message, shown):
    status = driving()
    status.take(Mode(mode=Mode.UNKNOWN, wanted=Mode.SAFE, reason='no robot answers'))
    assert 'NO ROBOT  no robot answers' in status.line()
    link = diagnostics('serial link', DiagnosticStatus.ERROR, message)
    link.status[0].values = [KeyValue(key='port', value=PORT)]
    status.take(link)
    assert f'NO ROBOT  {shown}' in status.line()
    status.take(diagnostics('serial link', DiagnosticStatus.OK, 'frames arrive'))
    assert 'NO ROBOT  no robot answers' in status.line()


@pytest.mark.parametrize('message', ['x' * 200, 'low: charge it soon'])
@given(x=ANY, yaw=ANY)
def test_the_line_always_fits(message, x, yaw):
    status = driving(x, yaw)
    status.take(Bumper(left=True, right=True))
    status.take(diagnostics('battery', DiagnosticStatus.WARN, message))
    line = status.line()
    assert len(line) <= WIDTH == 80
    assert message[:10] in line
    assert f'x {x:+.2f} y +0.00 m' in line
