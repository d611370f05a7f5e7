# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Converts readings and estimates to ROS messages, and requests to the protocol's types. Pure.

Units are SI here; nowhere else are they converted. A message that is published often is made once
and filled again: `odometry(message, estimate)` sets the fields that change, for example.
"""

from collections.abc import Callable, Iterable, Mapping
from enum import IntFlag
from math import atan2, cos, isnan, nan, remainder, sin, tau
from numbers import Integral, Real
import struct
from typing import Any

from builtin_interfaces.msg import Duration, Time
from create_oi_msgs import msg
from create_oi_msgs.msg import Mode
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, Imu, JointState, PointCloud2, PointField
from std_msgs.msg import Header

from tf2_msgs.msg import TFMessage

from .. import oi
from ..driver import battery, Charging, ModeStatus
from ..driver.events import NO_ROBOT
from ..odometry import Estimate
from ..oi import ChargingState, DigitalInputs, Infrared, Readings
from ..robot import MILLI

NANOSECONDS = 1_000_000_000
NOT_MEASURED = 1e6
"""Variance of axes that are not measured: height, roll, pitch, and speeds along them."""
SIDEWAYS = 1e-4
"""Variance of the speed sideways, (m/s)²: wheels do not move sideways, but a robot slips."""
X, Y, YAW = 0, 1, 5
"""Their places among the six axes of ROS; the same of the speeds along them."""
POSE_COVARIANCE = [6 * row + column for row in (X, Y, YAW) for column in (X, Y, YAW)]
"""Where ROS's covariance has that of x, y and yaw, row by row."""
TWIST_VARIANCES = [7 * X, 7 * YAW]
"""Where it has the variances of forward and turning speed."""
Values = dict[str, Any]
"""Values of fields of a message, by their names."""
HEIGHT = 0.05
"""Metres above the floor of the points of `contacts`: between the heights of an obstacle layer."""
POINT = struct.Struct('<fff')
WHEEL_JOINTS = ('left_wheel_joint', 'right_wheel_joint')


def seconds(duration: Duration) -> float:
    """Return a duration in seconds."""
    return float(duration.sec + duration.nanosec / NANOSECONDS)


def empty_odometry(odom_frame: str, base_frame: str) -> Odometry:
    """Return a message to be filled with `odometry`; axes that are not measured are set."""
    message = Odometry(header=Header(frame_id=odom_frame), child_frame_id=base_frame)
    message.pose.covariance = message.twist.covariance = [
        NOT_MEASURED if row == column else 0.0 for row in range(6) for column in range(6)]
    message.twist.covariance[7] = SIDEWAYS
    return message


def empty_transforms(odom_frame: str, base_frame: str) -> TFMessage:
    """Return a message to be filled with `transforms`."""
    return TFMessage(transforms=[TransformStamped(
        header=Header(frame_id=odom_frame), child_frame_id=base_frame)])


def empty_joint_states() -> JointState:
    """Return a message to be filled with `joint_states`."""
    nothing = [0.0] * len(WHEEL_JOINTS)
    return JointState(name=list(WHEEL_JOINTS), position=nothing, velocity=nothing)


GYRO_FRAME = 'gyro_link'


def beside(base_frame: str, name: str) -> str:
    """Return the name of a part's frame, with the prefix that the base's has."""
    return ''.join(base_frame.rpartition('/')[:2]) + name


def empty_imu(base_frame: str) -> Imu:
    """Return a message to be filled with `imu`; it says that only the turn rate is measured."""
    message = Imu(header=Header(frame_id=beside(base_frame, GYRO_FRAME)))
    message.orientation_covariance[0] = message.linear_acceleration_covariance[0] = -1.0
    message.angular_velocity_covariance[0] = NOT_MEASURED
    message.angular_velocity_covariance[4] = NOT_MEASURED
    return message


def empty_contacts(base_frame: str) -> PointCloud2:
    """Return a message to be filled with `contacts`."""
    fields = [PointField(name=name, offset=4 * place, datatype=PointField.FLOAT32, count=1)
              for place, name in enumerate('xyz')]
    return PointCloud2(header=Header(frame_id=base_frame), height=1, fields=fields,
                       is_bigendian=False, point_step=POINT.size, is_dense=True)


def contacts(message: PointCloud2, points: Iterable[tuple[float, float]]) -> None:
    """Set the points, m forward and to the left."""
    message.data = b''.join(POINT.pack(x, y, HEIGHT) for x, y in points)
    message.row_step = len(message.data)
    message.width = message.row_step // POINT.size


def imu(message: Imu, estimate: Estimate) -> None:
    """Set the turn rate of an estimate that has one, and its variance (REP 145)."""
    assert estimate.gyro is not None, 'the caller looks'
    message.angular_velocity.z, message.angular_velocity_covariance[8] = estimate.gyro


def odometry(message: Odometry, estimate: Estimate) -> None:
    """Set pose in the header's frame, and twist in the base frame (REP 105, 103)."""
    pose, twist = message.pose.pose, message.twist.twist
    pose.position.x, pose.position.y = estimate.x, estimate.y
    pose.orientation.z, pose.orientation.w = of_yaw(estimate.yaw)
    message.pose.covariance[POSE_COVARIANCE] = estimate.pose_covariance
    twist.linear.x, twist.angular.z = estimate.linear, estimate.angular
    message.twist.covariance[TWIST_VARIANCES] = estimate.twist_covariance


def transforms(message: TFMessage, estimate: Estimate) -> None:
    """Set the only transform: from the header's frame to the base."""
    moved = message.transforms[0].transform
    moved.translation.x, moved.translation.y = estimate.x, estimate.y
    moved.rotation.z, moved.rotation.w = of_yaw(estimate.yaw)


def joint_states(message: JointState, estimate: Estimate) -> None:
    """Set the measured angles, rad, and speeds, rad/s, of the wheels, the left one first."""
    position, velocity = message.position, message.velocity
    position[0], position[1] = estimate.left_wheel, estimate.right_wheel
    velocity[0], velocity[1] = estimate.left_wheel_speed, estimate.right_wheel_speed


def flags(field: str, kind: type[IntFlag], prefix: str = '') -> Callable[[Any, Readings], None]:
    """Return a function that sets flags of a message: which bits of a reading are set."""
    bits = {bit.name.removeprefix(prefix).lower(): int(bit)
            for bit in kind if bit.name is not None and bit.name.startswith(prefix)}

    def fill(message: Any, readings: Readings) -> None:
        for name, bit in bits.items():
            setattr(message, name, readings.number(field, 0) & bit != 0)
    return fill


bumper = flags('bumps_and_wheel_drops', oi.BumpsAndWheelDrops, 'BUMP_')
wheel_drop = flags('bumps_and_wheel_drops', oi.BumpsAndWheelDrops, 'WHEEL_DROP_')
buttons = flags('buttons', oi.Buttons)
overcurrent = flags('overcurrents', oi.Overcurrents)
charging_sources = flags('charging_sources', oi.ChargingSources)


def cliff(message: msg.Cliff, readings: Readings) -> None:
    """Set the cliff sensors and their signals (packets 9 to 12 and 28 to 31)."""
    for side in ('left', 'front_left', 'front_right', 'right'):
        setattr(message, side, readings.number(f'cliff_{side}', 0) != 0)
        signal = readings.number(f'cliff_{side}_signal', message.SIGNAL_UNKNOWN)
        setattr(message, f'{side}_signal', signal)


CHARGING = {
    Charging.NO_CHARGER: BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
    Charging.CHARGES: BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    Charging.FULL: BatteryState.POWER_SUPPLY_STATUS_FULL,
    Charging.FAILS: BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING,
    Charging.UNKNOWN: BatteryState.POWER_SUPPLY_STATUS_UNKNOWN,
}
"""Power supply status of what a charger does."""


def battery_state(message: BatteryState, readings: Readings, *, charge_known: bool = True) -> None:
    """
    Set the battery (packets 21 to 26 and 34); unknown values are NaN, as the message asks.

    The charge of the alkaline pack is not known (manual: Battery Charge). Real robots may report
    a charge a little above the capacity, and a capacity of 0; far above, the charge is not known.
    """
    degrees = readings.battery_temperature
    fraction = battery.charge_fraction(readings) if charge_known else nan
    message.present = True
    message.voltage, message.current = _milli(readings.voltage), _milli(readings.current)
    message.temperature = nan if degrees is None else float(degrees)
    message.charge = nan if isnan(fraction) else _milli(readings.battery_charge)
    message.capacity = readings.battery_capacity * MILLI if (
        charge_known and readings.battery_capacity) else nan
    message.design_capacity, message.percentage = nan, fraction
    message.power_supply_status = CHARGING[battery.charging(readings)]
    message.power_supply_health = (
        message.POWER_SUPPLY_HEALTH_UNSPEC_FAILURE
        if readings.charging_state == ChargingState.FAULT
        else message.POWER_SUPPLY_HEALTH_UNKNOWN)
    message.power_supply_technology = (
        message.POWER_SUPPLY_TECHNOLOGY_NIMH if charge_known
        else message.POWER_SUPPLY_TECHNOLOGY_UNKNOWN)


def _milli(thousandths: int | None) -> float:
    """Return thousandths of a unit in that unit; NaN where they are not known."""
    return nan if thousandths is None else thousandths * MILLI


def mode(status: ModeStatus, header: Header) -> Mode:
    """Return a message with the actual and the wanted mode, and why they differ."""
    return Mode(
        header=header, mode=Mode.UNKNOWN if status.actual is None else status.actual,
        wanted=status.wanted, reason=status.reason)


def mode_name(code: int, reason: str = NO_ROBOT) -> str:
    """Return the name of a mode in the message Mode; the reason tells why it is UNKNOWN."""
    if code in list(oi.Mode):
        return oi.Mode(code).name
    return 'NO ROBOT' if reason == NO_ROBOT else 'UNKNOWN'


def charging_name(code: int) -> str:
    """Return the name of a charging state in words; `state CODE` for a code without one."""
    if code not in list(ChargingState):
        return 'not known' if code == msg.Charging.UNKNOWN else f'state {code}'
    return ChargingState(code).name.lower().replace('_', ' ')


def wall(message: msg.Wall, readings: Readings) -> None:
    """Set the wall sensor and the virtual wall (packets 8, 13 and 27)."""
    message.wall, message.virtual_wall = readings.wall, readings.virtual_wall
    message.signal = readings.number('wall_signal', message.SIGNAL_UNKNOWN)


def ir_omni(message: msg.IrOmni, readings: Readings) -> None:
    """Set the infrared character and its name (packet 17)."""
    message.character = character = readings.infrared
    message.name = Infrared(character).name.lower() if character in list(Infrared) else ''


def charging(message: msg.Charging, readings: Readings) -> None:
    """Set the charging state and the sources (packets 21 and 34)."""
    message.state = readings.number('charging_state', message.UNKNOWN)
    charging_sources(message, readings)


def song(message: msg.Song, readings: Readings) -> None:
    """Set the number of the song and whether it plays (packets 36 and 37)."""
    message.number = readings.number('song_number', message.UNKNOWN)
    message.playing = readings.song_playing


def cargo_bay(message: msg.CargoBay, readings: Readings) -> None:
    """Set the inputs of the cargo bay connector (packets 32 and 33)."""
    inputs = readings.digital_inputs
    message.input_0 = DigitalInputs.INPUT_0 in inputs
    message.input_1 = DigitalInputs.INPUT_1 in inputs
    message.input_2 = DigitalInputs.INPUT_2 in inputs
    message.input_3 = DigitalInputs.INPUT_3 in inputs
    message.baud_rate_pin = DigitalInputs.BAUD_RATE_CHANGE in inputs
    message.analog = readings.analog_volts


def nanoseconds(stamp: Time) -> int:
    """Return a stamp in nanoseconds, also one before 1970, which rclpy's Time refuses."""
    return int(stamp.sec * NANOSECONDS + stamp.nanosec)


def leds(request: Any) -> oi.Leds:
    bits = oi.LedBits.PLAY * request.play | oi.LedBits.ADVANCE * request.advance
    return oi.Leds(bits=bits, color=request.power_color, intensity=request.power_intensity)


def filled(message: Any, values: Mapping[str, Any], where: str) -> Any:
    """
    Set fields of a message, also those of messages in it, and return it.

    A mapping stands for a message in it. Whole numbers become floats where the field has floats.
    ValueError: there is no such field, or the value does not fit; without its check fields, ROS
    would send something else, or abort.
    """
    types = message.get_fields_and_field_types()
    for field, value in values.items():
        if field not in types:
            raise ValueError(f'{where} has no field {field!r:.50}; allowed: '
                             f'{", ".join(types) or "none"}')
        present = getattr(message, field)
        if hasattr(value, 'get_fields_and_field_types') and type(value) is type(present):
            value = {part: getattr(value, part) for part in value.get_fields_and_field_types()}
        try:
            if isinstance(value, Mapping) and '/' in types[field]:
                value = filled(type(present)(check_fields=True), value, f'{where}: {field}')
            setattr(message, field, _number(value, types[field]))
        except (AssertionError, OverflowError):  # 10 ** 400 is no float
            raise ValueError(f'{where}: {field} = {value!r:.50}; allowed is a value of type '
                             f'{types[field]}') from None
    return message


def _number(value: Any, kind: str) -> Any:
    """Return a number, or all numbers of a list, as a field of this type takes it."""
    if isinstance(value, list | tuple):
        return [_number(each, kind) for each in value]
    if not isinstance(value, Real) or isinstance(value, bool):
        return value
    if 'float' in kind or 'double' in kind:
        return float(value)
    return int(value) if isinstance(value, Integral) else value  # such as one of numpy's


def of_yaw(yaw: float) -> tuple[float, float]:
    """Return z and w of the quaternion that turns by `yaw` radians; its x and y are 0."""
    return sin(yaw / 2), cos(yaw / 2)


def yaw_of(rotation: Any) -> float:
    """Return the yaw of a quaternion, -pi to pi."""
    return remainder(2 * atan2(rotation.z, rotation.w), tau)
