# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The topics, each declared once: name, type, quality of service, when and how it is published.

The publishers and the tables of docs/interface.md come from here. A new sensor topic takes three
files: its .msg file in msg_defs, its row here, its function in messages.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import Any

from create_oi_msgs import msg
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState, Imu, JointState, PointCloud2

from tf2_msgs.msg import TFMessage

from ..driver.contacts import CLIFFS
from ..driver.motion import BUMPS
from ..oi import Readings
from . import messages

RELIABLE = QoSProfile(depth=10)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For topics that change rarely: a late subscriber gets the present state."""

CMD_VEL = 'cmd_vel'
"""The topic of velocity commands."""
GOAL_POSE = 'goal_pose'
"""The topic of places to drive to, which RViz publishes."""


@dataclass(frozen=True, kw_only=True)
class Topic:
    """One published topic."""

    name: str
    type: type
    about: str
    when: str
    qos: QoSProfile = field(default_factory=lambda: RELIABLE)

    @property
    def latched(self) -> bool:
        """Whether it is kept for late subscribers."""
        return self.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL

    @property
    def overridable(self) -> tuple[QoSPolicyKind, ...]:
        """What `qos_overrides` may change; late subscribers need a reliable publisher."""
        kinds = QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY
        return kinds[:2] if self.latched else kinds

    @property
    def subscription_qos(self) -> QoSProfile:
        """What a subscriber asks for that gets it whatever `qos_overrides` say."""
        return self.qos if self.latched else QoSProfile(
            depth=self.qos.depth, reliability=ReliabilityPolicy.BEST_EFFORT)


@dataclass(frozen=True, kw_only=True)
class SensorTopic(Topic):
    """A topic that is made from readings."""

    when: str = 'on change at once, else at `sensor_rate`'
    watch: tuple[str, ...]
    """Readings whose change is published at once."""
    needs: tuple[str, ...] = ()
    """More readings that must have arrived before the first message."""
    bits: int | None = None
    """Bits of the only watched reading that count; None: all."""
    fill: Callable[[Any, Readings], None]
    """Sets all fields of a message but its header."""
    period: float | None = None
    """Seconds between two messages while nothing changes; None: at `sensor_rate`."""


@dataclass(frozen=True, kw_only=True)
class StateTopic(SensorTopic):
    """A topic that is published on change only, and kept for late subscribers."""

    when: str = 'on change; transient local'
    period: float | None = inf
    qos: QoSProfile = field(default_factory=lambda: LATCHED)


ODOM = Topic(
    name='odom', type=Odometry, when='every frame (66.7 Hz), or at `odom_rate`',
    about='pose in `odom_frame`, velocity in `base_frame`, with covariances')
TF = Topic(
    name='/tf', type=TFMessage, when='like `odom`, with `publish_tf`', qos=QoSProfile(depth=100),
    about='`odom_frame` -> `base_frame`; can be remapped')
JOINT_STATES = Topic(
    name='joint_states', type=JointState, when='like `odom`',
    about=f'measured angle and speed of {" and ".join(f"`{n}`" for n in messages.WHEEL_JOINTS)}')
IMU = Topic(
    name='imu/data', type=Imu, when='every frame in which the gyro is believed',
    about=f'turn rate by the gyro, in `{messages.GYRO_FRAME}`; with parameter `gyro` (REP 145)')
MODE = Topic(
    name='mode', type=msg.Mode, when='on change; transient local', qos=LATCHED,
    about='the actual mode, or `UNKNOWN`; the wanted one, and why they differ')
DIAGNOSTICS = Topic(
    name='/diagnostics', type=DiagnosticArray, when='1 Hz',
    about='battery, safety, mode, serial link, driver, odometry, version and parameters (REP 107)')
CONTACTS = Topic(
    name='contacts', type=PointCloud2,
    when='on change at once, at `sensor_rate` while there are points, else 1 Hz',
    about='what bumper, cliffs and virtual wall feel, as points in `base_frame`, for costmaps')

SENSOR_TOPICS: tuple[SensorTopic, ...] = (
    SensorTopic(
        name='bumper', type=msg.Bumper, fill=messages.bumper,
        watch=('bumps_and_wheel_drops',), bits=BUMPS,
        about='the two halves of the bumper'),
    SensorTopic(
        name='wheel_drop', type=msg.WheelDrop, fill=messages.wheel_drop,
        watch=('bumps_and_wheel_drops',), bits=~BUMPS,
        about='wheels and caster that hang in the air'),
    SensorTopic(
        name='cliff', type=msg.Cliff, fill=messages.cliff,
        watch=CLIFFS, needs=tuple(f'{name}_signal' for name in CLIFFS),
        about='the four cliff sensors, with signal strengths, or `SIGNAL_UNKNOWN`'),
    SensorTopic(
        name='wall', type=msg.Wall, fill=messages.wall,
        watch=('wall', 'virtual_wall'), needs=('wall_signal',),
        about='the wall sensor on the right, with its signal strength or `SIGNAL_UNKNOWN`, and '
        'virtual walls'),
    SensorTopic(
        name='cargo_bay', type=msg.CargoBay, fill=messages.cargo_bay, qos=LATCHED,
        watch=('digital_inputs',), needs=('analog_signal',),
        when='on change at once, else at `sensor_rate`; transient local',
        about='digital inputs, analog input in volts (NaN: not known), baud rate pin'),
    StateTopic(
        name='buttons', type=msg.Buttons, fill=messages.buttons, watch=('buttons',),
        about='Play and Advance'),
    StateTopic(
        name='ir_omni', type=msg.IrOmni, fill=messages.ir_omni, watch=('infrared',),
        about='infrared character that is received, with its name'),
    StateTopic(
        name='charging', type=msg.Charging, fill=messages.charging,
        watch=('charging_state', 'charging_sources'),
        about='charging state or `UNKNOWN`, charger and Home Base'),
    StateTopic(
        name='overcurrent', type=msg.Overcurrent, fill=messages.overcurrent,
        watch=('overcurrents',),
        about='wheels and low side drivers that draw too much'),
    StateTopic(
        name='song', type=msg.Song, fill=messages.song,
        watch=('song_number', 'song_playing'),
        about='the song that plays, or played last; its number may be `UNKNOWN`'),
    SensorTopic(
        name='battery_state', type=BatteryState, period=1.0,
        fill=messages.battery_state,
        watch=('charging_state', 'charging_sources'),
        needs=('voltage', 'current', 'battery_temperature', 'battery_charge', 'battery_capacity'),
        when='1 Hz, and when the charging state changes',
        about='voltage, current, charge, temperature, charging status; NaN: not known'),
)
PUBLISHED: tuple[Topic, ...] = (
    ODOM, TF, JOINT_STATES, *SENSOR_TOPICS, CONTACTS, MODE, DIAGNOSTICS)
"""Topics of every robot."""
ALL_TOPICS = (*PUBLISHED, IMU)
"""These, and those that need a part."""


def type_name(type_: Any) -> str:
    """Return the name of a message, service or action type as people write it."""
    package = type_.__module__.partition('.')[0]
    return f'{package}/{type_.__name__}'
