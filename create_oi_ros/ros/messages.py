# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Converts readings and estimates to ROS messages, and requests to the protocol's types. Pure.

Units are SI here; nowhere else are they converted. A message that is published often is made once,
by `empty...`; a function returns the values of its fields that change, by their paths in it.
"""

from collections.abc import Callable
from enum import IntFlag
from math import atan2, cos, isnan, nan, remainder, sin, tau
from typing import Any

from builtin_interfaces.msg import Duration, Time
from create_oi_msgs.msg import Mode
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, Imu, JointState
from std_msgs.msg import Header

from tf2_msgs.msg import TFMessage

from .. import oi
from ..driver import battery, Charging, ModeStatus
from ..driver.events import NO_ROBOT
from ..odometry import Estimate
from ..oi import ChargingState, Infrared, Readings
from ..robot import MILLI

NANOSECONDS = 1_000_000_000
NOT_MEASURED = 1e6
"""Variance of axes that are not measured: height, roll, pitch, and speeds along them."""
SIDEWAYS = 1e-4
"""Variance of the speed sideways, (m/s)²: wheels do not move sideways, but a robot slips."""
POSE_AXES, TWIST_AXES = (0, 1, 5), (0, 5)
"""Indices of x, y, yaw, and of forward and turning speed, among the six axes of ROS."""
POSE_COVARIANCE = tuple(
    f'pose.covariance[{6 * row + column}]' for row in POSE_AXES for column in POSE_AXES)
"""The covariance of x, y and yaw, row by row."""
TWIST_COVARIANCE = tuple(f'twist.covariance[{7 * axis}]' for axis in TWIST_AXES)
"""The variances of the speeds."""
UNKNOWN_CODE, UNKNOWN_SIGNAL = Mode.UNKNOWN, 0xffff
"""A code and a signal that are not known, in fields that have no NaN: no robot has them."""
Values = dict[str, Any]
"""Values of fields of a message, by their paths in it, such as `pose.covariance[7]`."""
WHEEL_JOINTS = ('left_wheel_joint', 'right_wheel_joint')


def seconds(duration: Duration) -> float:
    """Return a duration in seconds."""
    return float(duration.sec + duration.nanosec / NANOSECONDS)


def duration(length: float) -> Duration:
    sec, nanosec = divmod(round(length * NANOSECONDS), NANOSECONDS)
    return Duration(sec=sec, nanosec=nanosec)


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
"""The gyro's frame; it has the prefix of the base's."""


def empty_imu(base_frame: str) -> Imu:
    """Return a message to be filled with `imu`; it says that only the turn rate is measured."""
    prefix = ''.join(base_frame.rpartition('/')[:2])
    message = Imu(header=Header(frame_id=prefix + GYRO_FRAME))
    message.orientation_covariance[0] = message.linear_acceleration_covariance[0] = -1.0
    message.angular_velocity_covariance[0] = NOT_MEASURED
    message.angular_velocity_covariance[4] = NOT_MEASURED
    return message


def imu(estimate: Estimate) -> Values:
    """Return the turn rate of an estimate that has one, and its variance (REP 145)."""
    assert estimate.gyro is not None, 'the caller looks'
    rate, variance = estimate.gyro
    return {'angular_velocity.z': rate, 'angular_velocity_covariance[8]': variance}


def odometry(estimate: Estimate) -> Values:
    """Return pose in the header's frame, and twist in the base frame (REP 105, 103)."""
    z, w = of_yaw(estimate.yaw)
    return {
        'pose.pose.position.x': estimate.x, 'pose.pose.position.y': estimate.y,
        'pose.pose.orientation.z': z, 'pose.pose.orientation.w': w,
        **dict(zip(POSE_COVARIANCE, estimate.pose_covariance)),
        'twist.twist.linear.x': estimate.linear, 'twist.twist.angular.z': estimate.angular,
        **dict(zip(TWIST_COVARIANCE, estimate.twist_covariance))}


def transforms(estimate: Estimate) -> Values:
    """Return the only transform: from the header's frame to the base."""
    z, w = of_yaw(estimate.yaw)
    return {
        'transforms[0].transform.translation.x': estimate.x,
        'transforms[0].transform.translation.y': estimate.y,
        'transforms[0].transform.rotation.z': z, 'transforms[0].transform.rotation.w': w}


def joint_states(estimate: Estimate) -> Values:
    """Return the measured angles, rad, and speeds, rad/s, of the wheels, the left one first."""
    return {
        'position[0]': estimate.left_wheel, 'position[1]': estimate.right_wheel,
        'velocity[0]': estimate.left_wheel_speed, 'velocity[1]': estimate.right_wheel_speed}


def flags(field: str, kind: type[IntFlag], prefix: str = '') -> Callable[[Readings], Values]:
    """Return a function from readings to flags: which bits of a field are set, by their names."""
    bits = {bit.name.removeprefix(prefix).lower(): int(bit)
            for bit in kind if bit.name is not None and bit.name.startswith(prefix)}
    return lambda readings: {
        name: readings.number(field, 0) & bit != 0 for name, bit in bits.items()}


bumper = flags('bumps_and_wheel_drops', oi.BumpsAndWheelDrops, 'BUMP_')
wheel_drop = flags('bumps_and_wheel_drops', oi.BumpsAndWheelDrops, 'WHEEL_DROP_')
buttons = flags('buttons', oi.Buttons)
overcurrent = flags('overcurrents', oi.Overcurrents)
digital_inputs = flags('digital_inputs', oi.DigitalInputs)
charging_sources = flags('charging_sources', oi.ChargingSources)


def cliff(readings: Readings) -> Values:
    """Return the cliff sensors and their signals (packets 9 to 12 and 28 to 31)."""
    return {
        'left': readings.cliff_left, 'front_left': readings.cliff_front_left,
        'front_right': readings.cliff_front_right, 'right': readings.cliff_right,
        **{f'{side}_signal': readings.number(f'cliff_{side}_signal', UNKNOWN_SIGNAL)
           for side in ('left', 'front_left', 'front_right', 'right')}}


CHARGING = {
    Charging.NO_CHARGER: BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
    Charging.CHARGES: BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    Charging.FULL: BatteryState.POWER_SUPPLY_STATUS_FULL,
    Charging.FAILS: BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING,
    Charging.UNKNOWN: BatteryState.POWER_SUPPLY_STATUS_UNKNOWN,
}
"""Power supply status of what a charger does."""


def battery_state(readings: Readings, *, charge_known: bool = True) -> Values:
    """
    Return the battery (packets 21 to 26 and 34); unknown values are NaN, as the message asks.

    The charge of the alkaline pack is not known (manual: Battery Charge). Real robots may report
    a charge a little above the capacity, and a capacity of 0; far above, the charge is not known.
    """
    faulty = readings.charging_state == ChargingState.FAULT
    fraction = battery.charge_fraction(readings) if charge_known else nan
    charge = nan if isnan(fraction) else _milli(readings.battery_charge)
    capacity = readings.battery_capacity * MILLI if (
        charge_known and readings.battery_capacity) else nan
    health = (BatteryState.POWER_SUPPLY_HEALTH_UNSPEC_FAILURE if faulty
              else BatteryState.POWER_SUPPLY_HEALTH_UNKNOWN)
    technology = (BatteryState.POWER_SUPPLY_TECHNOLOGY_NIMH if charge_known
                  else BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN)
    degrees = readings.battery_temperature
    return {
        'present': True, 'voltage': _milli(readings.voltage), 'current': _milli(readings.current),
        'temperature': nan if degrees is None else float(degrees),
        'charge': charge, 'capacity': capacity, 'design_capacity': nan,
        'percentage': fraction,
        'power_supply_status': CHARGING[battery.charging(readings)],
        'power_supply_health': health, 'power_supply_technology': technology}


def _milli(thousandths: int | None) -> float:
    """Return thousandths of a unit in that unit; NaN where they are not known."""
    return nan if thousandths is None else thousandths * MILLI


def mode(status: ModeStatus, header: Header) -> Mode:
    """Return a message with the actual and the wanted mode, and why they differ."""
    return Mode(
        header=header, mode=Mode.UNKNOWN if status.actual is None else status.actual,
        wanted=status.wanted, reason=status.reason)


MODE_NAMES = {mode.value: mode.name for mode in oi.Mode}


def mode_name(code: int, reason: str = NO_ROBOT) -> str:
    """Return the name of a mode in the message Mode; the reason tells why it is UNKNOWN."""
    return MODE_NAMES.get(code, 'NO ROBOT' if reason == NO_ROBOT else 'UNKNOWN')


def charging_name(code: int) -> str:
    """Return the name of a charging state in words; `state CODE` for a code without one."""
    if code not in list(ChargingState):
        return 'not known' if code == UNKNOWN_CODE else f'state {code}'
    return ChargingState(code).name.lower().replace('_', ' ')


def wall(readings: Readings) -> Values:
    """Return the wall sensor and the virtual wall (packets 8, 13 and 27)."""
    return {'wall': readings.wall, 'virtual_wall': readings.virtual_wall,
            'signal': readings.number('wall_signal', UNKNOWN_SIGNAL)}


def ir_omni(readings: Readings) -> Values:
    """Return the infrared character and its name (packet 17)."""
    character = readings.infrared
    name = Infrared(character).name.lower() if character in list(Infrared) else ''
    return {'character': character, 'name': name}


def charging(readings: Readings) -> Values:
    """Return the charging state and the sources (packets 21 and 34)."""
    return {'state': readings.number('charging_state', UNKNOWN_CODE), **charging_sources(readings)}


def song(readings: Readings) -> Values:
    """Return the number of the song and whether it plays (packets 36 and 37)."""
    return {'number': readings.number('song_number', UNKNOWN_CODE),
            'playing': readings.song_playing}


def cargo_bay(readings: Readings) -> Values:
    """Return the inputs of the cargo bay connector (packets 32 and 33)."""
    values = digital_inputs(readings)
    values['baud_rate_pin'] = values.pop('baud_rate_change')
    values['analog'] = readings.analog_volts
    return values


def nanoseconds(stamp: Time) -> int:
    """Return a stamp in nanoseconds, also one before 1970, which rclpy's Time refuses."""
    return int(stamp.sec * NANOSECONDS + stamp.nanosec)


def leds(request: Any) -> oi.Leds:
    bits = oi.LedBits.PLAY * request.play | oi.LedBits.ADVANCE * request.advance
    return oi.Leds(bits=bits, color=request.power_color, intensity=request.power_intensity)


def of_yaw(yaw: float) -> tuple[float, float]:
    """Return z and w of the quaternion that turns by `yaw` radians; its x and y are 0."""
    return sin(yaw / 2), cos(yaw / 2)


def yaw_of(rotation: Any) -> float:
    """Return the yaw of a quaternion, -pi to pi."""
    return remainder(2 * atan2(rotation.z, rotation.w), tau)
