# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes synthetic bags of a robot: a circle, a bump, a cliff, a song, a gap."""

from collections.abc import Iterator
from math import cos, sin
from pathlib import Path
from typing import Any

from create_oi_msgs.msg import Bumper, Buttons, Charging, Cliff, Mode, Song
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from rclpy.time import Time
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

from create_oi_ros.ros.bags import definitions, full_name
from create_oi_ros.ros.messages import of_yaw

STORE = definitions()
BEGAN = 1_700_000_000_000_000_000


def header(time: float) -> Header:
    """Return the header of a message."""
    return Header(stamp=Time(nanoseconds=BEGAN + round(time * 1e9)).to_msg())


def twist(speed: float, turn: float) -> Twist:
    """Return a velocity."""
    return Twist(linear=Vector3(x=speed), angular=Vector3(z=turn))


def odometry(time: float, turn: float = 0.5) -> Odometry:
    """Return the odometry of a robot that drives a circle of 0.4 m radius."""
    yaw, made = turn * time, Odometry(header=header(time))
    pose, made.twist.twist = made.pose.pose, twist(0.2, turn)
    pose.position.x, pose.position.y = 0.4 * sin(yaw), 0.4 - 0.4 * cos(yaw)
    pose.orientation.z, pose.orientation.w = of_yaw(yaw)
    return made


def status(name: str, level: int, message: str, **values: str) -> DiagnosticStatus:
    """Return one status of the diagnostics."""
    return DiagnosticStatus(
        level=bytes([level]), name=name, message=message, hardware_id='iRobot Create', values=[
            KeyValue(key=key.replace('_', ' '), value=value) for key, value in values.items()])


def diagnostics(time: float, node: str) -> DiagnosticArray:
    """Return the diagnostics of the node; the serial link is bad from 5 s to 7 s."""
    bad = 5 <= time < 7
    return DiagnosticArray(header=header(time), status=[
        status(f'{node}: serial link', int(bad), 'bytes arrive damaged' if bad else 'all well',
               frames_per_second='66.0', damaged_frames=str(3 * bad), garbage_bytes='0'),
        status(f'{node}: parameters', 0, 'version 9.8.7', version='9.8.7', port='/dev/robot')])


def modes(time: float) -> Mode:
    """Return the mode at a time: Passive from 8 s to 9 s, else Safe."""
    passive = 8 <= time < 9
    return Mode(header=header(time), mode=Mode.PASSIVE if passive else Mode.SAFE,
                wanted=Mode.SAFE, reason='a cliff' if passive else '')


def battery(time: float) -> BatteryState:
    """Return a battery that is discharging."""
    return BatteryState(header=header(time), voltage=15.0 - time / 1000, current=-0.3,
                        percentage=max(0.0, 0.9 - time / 10000))


def messages(
    seconds: float, gap: tuple[float, float], node: str,
) -> Iterator[tuple[float, str, Any]]:
    """Yield time, topic and message, in order of time."""
    yield 0.0, 'buttons', Buttons(header=header(0.0))
    yield 0.0, 'charging', Charging(header=header(0.0))
    for frame in range(int(seconds / 0.015)):
        time = frame * 0.015
        if gap[0] <= time < gap[1]:
            continue
        yield time, 'odom', odometry(time)
        if frame % 3 == 0:
            yield time, 'cmd_vel', twist(0.2, 0.5)
            yield time, 'bumper', Bumper(
                header=header(time), left=3 <= time < 3.5, right=3.2 <= time < 3.5)
            yield time, 'cliff', Cliff(
                header=header(time), front_left=8 <= time < 9, left_signal=frame % 4000)
        if frame % 66 == 0:
            yield time, 'battery_state', battery(time)
            yield time, '/diagnostics', diagnostics(time, node)
            yield time, 'mode', modes(time)
            yield time, 'song', Song(header=header(time), number=4, playing=1 <= time < 3)


def write(
    path: Path, seconds: float = 12.0, *, gap: tuple[float, float] = (5.0, 5.0),
    storage: StoragePlugin = StoragePlugin.MCAP, robots: tuple[str, ...] = ('',),
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """Write a bag and return its folder."""
    writer = Writer(path, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        made: dict[str, Any] = {}
        for robot in robots:
            node = f'{robot}/create'.lstrip('/')
            for time, topic, message in messages(seconds, gap, node):
                name = topic if topic.startswith('/') else f'{robot}/{topic}'
                name = f'/{name.lstrip("/")}'
                if name not in made:
                    made[name] = writer.add_connection(
                        name, full_name(type(message)), typestore=STORE)
                writer.write(made[name], BEGAN + round(time * 1e9), serialize_message(message))
    return path
