# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_run` as a user sees it: one command, a robot that can be driven, a clean end."""

from contextlib import closing
from itertools import cycle
import json
from math import dist, inf, nan, pi
import os
from pathlib import Path
import re
import signal
import socket

from create_oi_msgs.msg import Bumper, Mode
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, LaserScan
import yaml

from create_oi_ros.apps import run as create_run
from create_oi_ros.apps.run import RobotStatus, WIDTH
from create_oi_ros.oi.tools.capture_format import CaptureReader, RecordKind, records_of
from create_oi_ros.ros.collector import NAMES
from create_oi_ros.ros.diagnostics import LINK
from create_oi_ros.ros.messages import of_yaw
from create_oi_ros.ros.topics import LATCHED
from create_oi_ros.sim.server.create_sim import say
from support.ros import children_of
from support.web import ADDRESS, PageClient, ready
from tf2_msgs.msg import TFMessage

SLAM = Path(__file__).parents[2] / 'config' / 'with' / 'slam_toolbox.yaml'


def scans_of_the_room_come_as_slam_and_nav2_expect_them(stage, odom) -> None:
    """Look at scans where the robot starts; `odom` is what came of its odometry."""
    scans = stage.ros.listen(LaserScan, '/scan', qos_profile_sensor_data)
    transforms = stage.ros.listen(TFMessage, '/tf_static', LATCHED)
    stage.ros.until(lambda: len(scans) > 10)
    slam = yaml.safe_load(SLAM.read_text())['slam_toolbox']['ros__parameters']
    scan = scans[-1]
    assert slam['scan_topic'] == '/scan'
    assert scan.range_max == pytest.approx(slam['max_laser_range'])
    assert (scan.range_min, scan.scan_time) == pytest.approx((0.12, 0.1))
    transform, = (each for message in transforms for each in message.transforms)
    assert transform.header.frame_id == slam['base_frame'] == odom[-1].child_frame_id
    assert transform.child_frame_id == scan.header.frame_id == 'laser'
    assert transform.transform.translation.z == pytest.approx(0.12)
    assert len(scan.ranges) == 360
    assert scan.angle_min == pytest.approx(-pi)
    assert scan.angle_max == pytest.approx(scan.angle_min + 359 * scan.angle_increment)
    for beam, wall in ((0, 2.0), (90, 1.5), (180, 2.0), (270, 1.5)):
        assert scan.ranges[beam] == pytest.approx(wall, abs=0.05)
    stamps = [(each.header.stamp.sec, each.header.stamp.nanosec) for each in scans]
    assert stamps == sorted(set(stamps))


def test_it_starts_a_robot_that_drives_and_ends_cleanly(stage):
    path = stage.folder / 'walk.capture'
    run = stage.program('create_run', '--world', 'room', '--lidar', '--capture', str(path))
    odom = stage.ros.listen(Odometry, 'odom')
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: modes and modes[-1].mode == Mode.SAFE and odom)
    assert f'ROS domain {stage.domain}' in run.output
    steady = re.compile(
        r'^6\d frames/s  SAFE     x \S+ y \S+ m  +\S+ deg  \d+%  \S+ m/s  \S+ rad/s$', re.M)
    stage.ros.until(lambda: steady.search(run.output))
    scans_of_the_room_come_as_slam_and_nav2_expect_them(stage, odom)
    example = stage.example('drive.py')
    stage.ros.until(lambda: odom[-1].pose.pose.position.x > 0.2)
    assert example.ended() == 0
    # On a busy computer it may have to wait for the driver, and says so.
    assert re.fullmatch(r'(drive: waits .*\n)?(x \S+ y \S+ m\n)+', example.output)
    assert all(len(line) <= 81 for line in run.printed if 'frames/s' in line)
    stage.ros.until(lambda: ADDRESS.search(run.output))
    assert re.fullmatch(r'http://127\.0\.0\.1:\d+/', ADDRESS.search(run.output)[1])
    assert 'create_node --ros-args' not in run.output, 'which would start a second driver'
    control = re.search(r'create_sim --control (\S+) --say "bump left 0.5"', run.output)[1]
    assert say('bump left 0.5', Path(control)) == 'ok'
    stage.ros.until(lambda: 'BUMP left' in run.output)
    second = stage.program('create_run', '--port', '/dev/null')
    assert second.ended() == 2
    assert f'/create runs already in ROS domain {stage.domain}' in second.output
    assert 'for phones in your network, too, add --host 0.0.0.0\n' in run.output
    children = children_of(run.pid)
    assert len(children) == 4
    run.send(signal.SIGINT)
    assert run.ended() == 0
    assert 'Traceback' not in run.output
    assert not any(Path(f'/proc/{child}').exists() for child in children)
    *_, last = records_of([path.read_bytes()], CaptureReader())
    assert last.kind is RecordKind.END
    assert not Path(re.search(r'Create on (/\S+)/create,', run.output)[1]).exists()


def test_what_follows_ros_args_is_for_the_node_and_phones_drive_it_until_run_is_killed(stage):
    (stage.folder / 'my.yaml').write_text('/**:\n  ros__parameters:\n    bump_stop: forward\n')
    kept = stage.folder / 'token'
    kept.write_text('a_token_that_lasts_long')
    kept.chmod(0o600)
    run = stage.program(
        'create_run', '--host', '0.0.0.0', '--token-file', str(kept), '--ros-args',
        '--params-file', str(stage.folder / 'my.yaml'), '-p', 'max_wheel_speed:=0.2', '-r',
        '__ns:=/robot1')
    stage.ros.until(lambda: re.search(r'6\d frames/s  SAFE     x', run.output))
    assert 'create_run starts node /robot1/create for a simulated Create' in run.output
    assert 'drive.py --ros-args -r __ns:=/robot1\n' in run.output or 'drive.py' not in run.output
    assert stage.ros.parameters(
        '/robot1/create', 'bump_stop', 'max_wheel_speed') == ['forward', 0.2]
    stage.ros.until(lambda: stage.ros.node.count_subscribers('/robot1/odom') == 2,
                    'status line and page listen')
    _, port, token = stage.ros.until(lambda: re.search(
        r'open (http://\S+:(\d+)/)\?token=(\S+) in', run.output), 'an address').groups()
    assert token == kept.read_text()
    with closing(PageClient(f'http://127.0.0.1:{port}/', token=token)) as page:
        ready(page)
        page.until(lambda: page.known.get('true_pose'))
        assert page.known['room']['walls'], 'the apartment'
        before = page.known['true_pose'][:2]
        page.drive(0.2, 0.0, lambda: dist(before, page.known['true_pose'][:2]) > 0.1)
    children = children_of(run.pid)
    run.send(signal.SIGKILL)
    assert run.ended() == -signal.SIGKILL
    stage.ros.until(lambda: not any(Path(f'/proc/{child}').exists() for child in children))
    assert 'Traceback' not in run.output


def test_a_missing_port_is_reported_and_run_continues_until_a_child_ends(stage):
    port = stage.folder / "[it's"  # any name is taken as a name
    run = stage.program('create_run', '--port', str(port))
    stage.ros.until(lambda: 'NO ROBOT  port does not exist; ' in run.output)
    assert f'starts node /create for the robot on {port}' in run.output
    assert 'drives' not in run.output
    # The page of a real robot is for this computer only, if nothing else is asked for.
    stage.ros.until(lambda: ADDRESS.search(run.output))
    assert ADDRESS.search(run.output)[1].startswith('http://127.0.0.1:')
    assert 'token' not in run.output
    node, = (child for child in children_of(run.pid)
             if 'create_node' in Path(f'/proc/{child}/cmdline').read_text())
    os.kill(node, signal.SIGKILL)
    assert run.ended() == 1
    assert 'create_node has ended' in run.output


@pytest.mark.parametrize(('arguments', 'words'), [
    (['--port', ''], '--port is empty'), (['--world', ''], '--world is empty'),
    (['--capture', ''], '--capture is empty'), (['--token-file', ''], '--token-file is empty'),
    (['--world', 'nowhere'], "'nowhere'; allowed: a file, or one of apartment, empty,"),
    (['--port', '/dev/ttyUSB0', '--world', 'room'], 'give one of them'),
    (['--port', '/dev/ttyUSB0', '--lidar'], '--lidar is for a simulated robot'),
    (['--ros-args', '-p', 'port:=/dev/ttyUSB0'], 'write --port'),
    (['-p', 'bump_stop:=forward'], 'write --ros-args -p bump_stop:=forward'),
    (['--prot', '/dev/ttyUSB0'], 'unknown argument --prot: did you mean --port?'),
    (['--tokenfile', 'token'], 'did you mean --token-file?'),
    (['--bmp-stop', 'any'], 'did you mean --ros-args -p bump_stop:=VALUE?'),
])
def test_arguments_that_make_no_sense_are_refused(capsys, arguments, words):
    with pytest.raises(SystemExit) as ended:
        create_run.main(arguments)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_on_a_terminal_the_status_line_stays_below_the_log(stage):
    run = stage.program('create_run', '--world', 'empty', terminal=True)

    def last() -> str:  # a terminal shows one line that changes in place
        return run.output.rpartition('\n')[2]  # the log may still have had a line before
    stage.ros.until(lambda: last().count(' frames/s  SAFE') > 2, 'three status lines in place')
    shown = last()[last().index(' frames/s  SAFE') - 2:]
    assert re.match(r'[ \d]\d frames/s  SAFE [^\x1b]*\r\r\x1b\[K', shown)
    # A line of the log clears the status line first, and stays.
    assert re.search(r'\r\x1b\[K\[INFO\].* robot answers', run.output)
    run.type('\x03')
    assert run.ended() == 0
    assert run.output.endswith('\n')


# The status line: what it shows, and that it fits.


NAME_OF = {topic.type: name for name, topic in NAMES.items()}
PORT = '/dev/serial/by-id/usb-FTDI_FT232R_USB_UART_A50285BI-if00-port0'
ANY = st.floats(-1e9, 1e9) | st.just(nan)


class Status(RobotStatus):
    """A status whose messages come one after the other, a tenth of a second apart."""

    now = 0.0

    def take(self, message: object) -> None:
        self.now += 0.1
        super().take(NAME_OF[type(message)], self.now, message)

    def line(self, width: int = WIDTH) -> str:
        self.now += 0.1
        return super().line(self.now, width)


def driving(x: float = 1.0, yaw: float = 0.0) -> Status:
    """Return the status of a robot in SAFE that drives."""
    status = Status()
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
    """Return the diagnostics of a driver with this status, and one of its line."""
    return DiagnosticArray(status=[
        DiagnosticStatus(name=f'create: {about}', level=level, message=message),
        *([] if about == LINK else [DiagnosticStatus(name=f'create: {LINK}')])])


def test_the_usual_line_counts_frames_anew_each_second():
    status = driving()
    assert status.line() == (
        ' 1 frames/s  SAFE     x +1.00 y +0.00 m    +0 deg  90%  +0.20 m/s  +0.00 rad/s')
    assert status.line().startswith(' 0 frames/s')
    assert Status().line() == ' 0 frames/s  no node yet'
    assert ' -170 deg' in driving(yaw=190 * pi / 180).line(), 'within half a turn'


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
    assert message.replace(PORT, 'port') in status.line(200), 'a wide terminal has room'
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


# `create_lidar`.


def test_where_nothing_is_near_all_ranges_are_infinite_and_the_end_of_the_robot_is_its_end(stage):
    sim = stage.program('create_sim', '--link', str(stage.folder / 'create'), '--control',
                        str(stage.folder / 'control'), '--world', 'empty')
    lidar = stage.program('create_lidar', '--control', str(stage.folder / 'control'),
                          '--frame', 'r1/laser', '--base-frame', 'r1/base_footprint')
    scans = stage.ros.listen(LaserScan, 'scan', qos_profile_sensor_data)
    stage.ros.until(lambda: scans)
    assert set(scans[-1].ranges) == {inf}
    assert scans[-1].header.frame_id == 'r1/laser'
    sim.send(signal.SIGINT)
    assert lidar.ended() == 0
    assert 'Traceback' not in lidar.output


def test_a_scan_that_would_be_older_than_one_that_was_late_is_left_out(stage):
    path = stage.folder / 'control'
    with socket.socket(socket.AF_UNIX) as door:
        door.bind(str(path))
        door.listen()
        stage.program('create_lidar', '--control', str(path), '--base-frame', 'base')
        scans = stage.ros.listen(LaserScan, 'scan', qos_profile_sensor_data)
        line = door.accept()[0].makefile('rw')
        ages = cycle((0.0, 0.09))  # seconds: the second one is older, though it comes later

        def heard():
            assert line.readline() == 'scan\n'
            line.write('ok ' + json.dumps({'age': next(ages), 'turn': 0.1, 'ranges': [1.0],
                                           'nearest': 0.1, 'farthest': 3.5}) + '\n')
            line.flush()
            return len(scans) > 10
        stage.ros.until(heard)
    stamps = [(each.header.stamp.sec, each.header.stamp.nanosec) for each in scans]
    assert stamps == sorted(set(stamps))
