# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Writes synthetic bags of a robot: a circle, a bump, a cliff, a song, a gap."""

from collections.abc import Iterator
from math import cos, sin
from pathlib import Path

import numpy
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from create_oi_ros.ros.bags import definitions

STORE = definitions()
TYPES = STORE.types
BEGAN = 1_700_000_000_000_000_000
TOPICS = {
    'odom': 'nav_msgs/msg/Odometry', 'cmd_vel': 'geometry_msgs/msg/Twist',
    'battery_state': 'sensor_msgs/msg/BatteryState',
    '/diagnostics': 'diagnostic_msgs/msg/DiagnosticArray', 'mode': 'create_oi_msgs/msg/Mode',
    'bumper': 'create_oi_msgs/msg/Bumper', 'cliff': 'create_oi_msgs/msg/Cliff',
    'song': 'create_oi_msgs/msg/Song', 'buttons': 'create_oi_msgs/msg/Buttons',
    'charging': 'create_oi_msgs/msg/Charging'}


def make(kind: str, **fields):
    """Return a message; fields that are not given are zero."""
    names = STORE.fielddefs[kind][1]
    return TYPES[kind](**{name: fields.get(name, zero(definition))
                          for name, definition in names if name.islower()})


def zero(definition):
    """Return the zero value of a field's type."""
    sort, rest = definition
    if sort == 2:
        return make(rest)
    if sort == 1:
        return {'string': '', 'bool': False}.get(rest[0], 0)
    (base, name), length = rest
    if base == 2 or name[0] == 'string':
        return []
    return numpy.zeros(length, name[0])


def header(time: float):
    """Return the header of a message."""
    nanoseconds = BEGAN + round(time * 1e9)
    return make('std_msgs/msg/Header', stamp=make(
        'builtin_interfaces/msg/Time', sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9))


def vector(**values: float):
    """Return a vector."""
    return make('geometry_msgs/msg/Vector3', **{'x': 0.0, 'y': 0.0, 'z': 0.0, **values})


def twist(speed: float, turn: float):
    """Return a velocity."""
    return make('geometry_msgs/msg/Twist', linear=vector(x=speed), angular=vector(z=turn))


def odometry(time: float, turn: float = 0.5):
    """Return the odometry of a robot that drives a circle of 0.4 m radius."""
    yaw = turn * time
    point = make('geometry_msgs/msg/Point', x=0.4 * sin(yaw), y=0.4 - 0.4 * cos(yaw), z=0.0)
    heading = make('geometry_msgs/msg/Quaternion', x=0.0, y=0.0, z=sin(yaw / 2), w=cos(yaw / 2))
    pose = make('geometry_msgs/msg/Pose', position=point, orientation=heading)
    return make('nav_msgs/msg/Odometry', header=header(time),
                pose=make('geometry_msgs/msg/PoseWithCovariance', pose=pose),
                twist=make('geometry_msgs/msg/TwistWithCovariance', twist=twist(0.2, turn)))


def status(name: str, level: int, message: str, **values: str):
    """Return one status of the diagnostics."""
    return make('diagnostic_msgs/msg/DiagnosticStatus', level=level, name=name, message=message,
                hardware_id='iRobot Create', values=[
                    make('diagnostic_msgs/msg/KeyValue', key=key.replace('_', ' '), value=value)
                    for key, value in values.items()])


def diagnostics(time: float, node: str):
    """Return the diagnostics of the node; the serial link is bad from 5 s to 7 s."""
    bad = 5 <= time < 7
    return make('diagnostic_msgs/msg/DiagnosticArray', header=header(time), status=[
        status(f'{node}: serial link', int(bad), 'bytes arrive damaged' if bad else 'all well',
               frames_per_second='66.0', damaged_frames=str(3 * bad), garbage_bytes='0'),
        status(f'{node}: parameters', 0, 'version 9.8.7', version='9.8.7', port='/dev/robot')])


def modes(time: float):
    """Return the mode at a time: Passive from 8 s to 9 s, else Safe."""
    passive = 8 <= time < 9
    return make('create_oi_msgs/msg/Mode', header=header(time), mode=1 if passive else 2,
                wanted=2, reason='a cliff' if passive else '')


def battery(time: float):
    """Return a battery that is discharging."""
    return make('sensor_msgs/msg/BatteryState', header=header(time), voltage=15.0 - time / 1000,
                current=-0.3, percentage=max(0.0, 0.9 - time / 10000))


def messages(
    seconds: float, gap: tuple[float, float], node: str,
) -> Iterator[tuple[float, str, object]]:
    """Yield time, topic and message, in order of time."""
    ours = 'create_oi_msgs/msg/'
    yield 0.0, 'buttons', make(f'{ours}Buttons', header=header(0.0))
    yield 0.0, 'charging', make(f'{ours}Charging', header=header(0.0))
    for frame in range(int(seconds / 0.015)):
        time = frame * 0.015
        if gap[0] <= time < gap[1]:
            continue
        yield time, 'odom', odometry(time)
        if frame % 3 == 0:
            yield time, 'cmd_vel', twist(0.2, 0.5)
            yield time, 'bumper', make(f'{ours}Bumper', header=header(time),
                                       left=3 <= time < 3.5, right=3.2 <= time < 3.5)
            yield time, 'cliff', make(f'{ours}Cliff', header=header(time),
                                      front_left=8 <= time < 9, left_signal=frame % 4000)
        if frame % 66 == 0:
            yield time, 'battery_state', battery(time)
            yield time, '/diagnostics', diagnostics(time, node)
            yield time, 'mode', modes(time)
            yield time, 'song', make(f'{ours}Song', header=header(time), number=4,
                                     playing=1 <= time < 3)


def write(
    path: Path, seconds: float = 12.0, *, gap: tuple[float, float] = (5.0, 5.0),
    storage: StoragePlugin = StoragePlugin.MCAP, robots: tuple[str, ...] = ('',),
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """Write a bag and return its folder."""
    writer = Writer(path, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        made = {}
        for robot in robots:
            node = f'{robot}/create'.lstrip('/')
            for time, topic, message in messages(seconds, gap, node):
                name = topic if topic.startswith('/') else f'{robot}/{topic}'
                name = f'/{name.lstrip("/")}'
                kind = TOPICS[topic]
                if name not in made:
                    made[name] = writer.add_connection(name, kind, typestore=STORE)
                writer.write(made[name], BEGAN + round(time * 1e9),
                             STORE.serialize_cdr(message, kind))
    return path
