"""
Converts readings and estimates to ROS messages, and requests to the protocol's types. Pure.

Units are SI here; nowhere else are they converted. A message that is published often is created
once and filled again: creating an Odometry costs more than sending it. Publishing copies it.
"""

from collections.abc import Callable
from math import nan

from builtin_interfaces.msg import Time
from create_oi_msgs.msg import (
    Bumper,
    Buttons,
    CargoBay,
    Charging,
    Cliff,
    IrOmni,
    Mode,
    Overcurrent,
    Song,
    Wall,
    WheelDrop,
)
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, JointState
from std_msgs.msg import Header

from tf2_msgs.msg import TFMessage

from .. import oi
from ..driver import ModeStatus
from ..odometry import Estimate
from ..oi import (
    BumpsAndWheelDrops,
    ChargingSources,
    ChargingState,
    DigitalInputs,
    Infrared,
    LedBits,
    OutputBits,
    Overcurrents,
    Readings,
    Script,
)
from ..oi.script import commands_of
from ..oi.tools.text import format_commands, parse_script
from ..robot import MILLI
from .rotation import set_yaw

VOLTS_PER_STEP = 5 / 1023
"""Resolution of the analog input (manual: Cargo Bay Analog Signal)."""
NANOSECONDS = 1_000_000_000
NOT_MEASURED = 1e6
"""Variance of axes that are not measured: height, roll, pitch, and speeds along them."""
POSE_AXES, TWIST_AXES = (0, 1, 5), (0, 5)
"""Indices of x, y, yaw, and of forward and turning speed, among the six axes of ROS."""
POSE_PLACES = tuple(6 * row + column for row in POSE_AXES for column in POSE_AXES)
"""Indices of the covariance of x, y and yaw, row by row, in the 36 numbers of ROS."""
TWIST_PLACES = tuple(7 * axis for axis in TWIST_AXES)
"""Indices of the variances of the speeds in the same 36 numbers."""
WHEEL_JOINTS = ('left_wheel_joint', 'right_wheel_joint')


def time(nanoseconds: int) -> Time:
    """Return a ROS time from nanoseconds since the epoch."""
    stamp = Time()
    set_time(stamp, nanoseconds)
    return stamp


def set_time(stamp: Time, nanoseconds: int) -> None:
    """Set a ROS time to nanoseconds since the epoch."""
    stamp.sec, stamp.nanosec = divmod(nanoseconds, NANOSECONDS)


def header(frame: str, stamp: Time) -> Header:
    """Return a header with a frame and a stamp."""
    return Header(frame_id=frame, stamp=stamp)


def unmeasured() -> list[float]:
    """Return a covariance of the six axes of ROS, none of them measured."""
    return [NOT_MEASURED if row == column else 0.0 for row in range(6) for column in range(6)]


def odometry(message: Odometry) -> Callable[[Estimate], None]:
    """
    Return a function that fills the message with an estimate.

    The pose is in the frame of the header, the twist in the base frame (REP 105, 103). Parts of
    the message are looked up only once, here: each access is a Python call.
    """
    message.pose.covariance = message.twist.covariance = unmeasured()
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    of_pose, of_twist = message.pose.covariance, message.twist.covariance

    def fill(estimate: Estimate) -> None:
        position.x, position.y = estimate.x, estimate.y
        set_yaw(orientation, estimate.yaw)
        for place, known in zip(POSE_PLACES, estimate.pose_covariance):
            of_pose[place] = known
        linear.x, angular.z = estimate.linear, estimate.angular
        for place, known in zip(TWIST_PLACES, estimate.twist_covariance):
            of_twist[place] = known
    return fill


def transforms(message: TFMessage) -> Callable[[Estimate], None]:
    """Return a function that fills the only transform: from the header's frame to the base."""
    transform = message.transforms[0].transform
    translation, rotation = transform.translation, transform.rotation

    def fill(estimate: Estimate) -> None:
        translation.x, translation.y = estimate.x, estimate.y
        set_yaw(rotation, estimate.yaw)
    return fill


def joint_states(message: JointState) -> Callable[[Estimate], None]:
    """Return a function that fills the measured angles, rad, and speeds, rad/s, of the wheels."""
    message.name = WHEEL_JOINTS
    message.position = message.velocity = [0.0] * len(WHEEL_JOINTS)
    angles, speeds = message.position, message.velocity

    def fill(estimate: Estimate) -> None:
        angles[0], angles[1] = estimate.left_wheel, estimate.right_wheel
        speeds[0], speeds[1] = estimate.left_wheel_speed, estimate.right_wheel_speed
    return fill


def bumper(message: Bumper, readings: Readings) -> None:
    """Fill in the bumper's two halves (packet 7)."""
    bits = readings.bumps_and_wheel_drops
    message.left = BumpsAndWheelDrops.BUMP_LEFT in bits
    message.right = BumpsAndWheelDrops.BUMP_RIGHT in bits


def wheel_drop(message: WheelDrop, readings: Readings) -> None:
    """Fill in the wheel drop sensors (packet 7)."""
    bits = readings.bumps_and_wheel_drops
    message.left = BumpsAndWheelDrops.WHEEL_DROP_LEFT in bits
    message.right = BumpsAndWheelDrops.WHEEL_DROP_RIGHT in bits
    message.caster = BumpsAndWheelDrops.WHEEL_DROP_CASTER in bits


def cliff(message: Cliff, readings: Readings) -> None:
    """Fill in the cliff sensors and their signals (packets 9 to 12 and 28 to 31)."""
    message.left = readings.cliff_left
    message.front_left = readings.cliff_front_left
    message.front_right = readings.cliff_front_right
    message.right = readings.cliff_right
    message.left_signal = readings.cliff_left_signal
    message.front_left_signal = readings.cliff_front_left_signal
    message.front_right_signal = readings.cliff_front_right_signal
    message.right_signal = readings.cliff_right_signal


CHARGING = {
    ChargingState.RECONDITIONING: BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    ChargingState.FULL_CHARGING: BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    ChargingState.TRICKLE: BatteryState.POWER_SUPPLY_STATUS_FULL,
    ChargingState.WAITING: BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING,
    ChargingState.FAULT: BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING,
}
"""Power supply status of a charging state; any other state is discharging."""


def battery_state(message: BatteryState, readings: Readings, *, charge_known: bool) -> None:
    """
    Fill in the battery (packets 21 to 26 and 34); unknown values are NaN, as the message asks.

    The charge of the alkaline pack is not known (manual: Battery Charge). Real robots may report
    a charge above the capacity, and a capacity of 0.
    """
    status = CHARGING.get(readings.charging_state, BatteryState.POWER_SUPPLY_STATUS_DISCHARGING)
    if readings.charging_state == ChargingState.NOT_CHARGING and readings.charging_sources:
        status = BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING
    faulty = readings.charging_state == ChargingState.FAULT
    charge, capacity = nan, nan
    if charge_known and readings.battery_capacity > 0:
        charge = readings.battery_charge * MILLI
        capacity = readings.battery_capacity * MILLI
    message.present = True
    message.voltage = readings.voltage * MILLI
    message.current = readings.current * MILLI
    message.temperature = float(readings.battery_temperature)
    message.charge, message.capacity, message.design_capacity = charge, capacity, nan
    message.percentage = min(charge / capacity, 1.0)
    message.power_supply_status = status
    message.power_supply_health = (
        BatteryState.POWER_SUPPLY_HEALTH_UNSPEC_FAILURE if faulty
        else BatteryState.POWER_SUPPLY_HEALTH_UNKNOWN)
    message.power_supply_technology = (
        BatteryState.POWER_SUPPLY_TECHNOLOGY_NIMH if charge_known
        else BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN)


def mode(status: ModeStatus, header: Header) -> Mode:
    """Return a message with the actual and the wanted mode, and why they differ."""
    return Mode(
        header=header, mode=Mode.UNKNOWN if status.actual is None else status.actual,
        wanted=status.wanted, reason=status.reason)


MODE_NAMES = {mode.value: mode.name for mode in oi.Mode}


def mode_name(code: int) -> str:
    """Return the name of a mode in the message Mode; NO ROBOT for any other code."""
    return MODE_NAMES.get(code, 'NO ROBOT')


def charging_name(code: int) -> str:
    """Return the name of a charging state in words; `state CODE` for an unknown code."""
    if code not in list(ChargingState):
        return f'state {code}'
    return ChargingState(code).name.lower().replace('_', ' ')


def wall(message: Wall, readings: Readings) -> None:
    """Fill in the wall sensor and the virtual wall (packets 8, 13 and 27)."""
    message.wall = readings.wall
    message.virtual_wall = readings.virtual_wall
    message.signal = readings.wall_signal


def buttons(message: Buttons, readings: Readings) -> None:
    """Fill in which buttons are pressed (packet 18)."""
    message.play = oi.Buttons.PLAY in readings.buttons
    message.advance = oi.Buttons.ADVANCE in readings.buttons


def ir_omni(message: IrOmni, readings: Readings) -> None:
    """Fill in the infrared character and its name (packet 17)."""
    character = readings.infrared
    message.character = character
    message.name = Infrared(character).name.lower() if character in list(Infrared) else ''


def charging(message: Charging, readings: Readings) -> None:
    """Fill in the charging state and the sources (packets 21 and 34)."""
    sources = readings.charging_sources
    message.state = readings.charging_state
    message.internal_charger = ChargingSources.INTERNAL_CHARGER in sources
    message.home_base = ChargingSources.HOME_BASE in sources


def overcurrent(message: Overcurrent, readings: Readings) -> None:
    """Fill in which wheels and drivers draw too much current (packet 14)."""
    bits = readings.overcurrents
    message.left_wheel = Overcurrents.LEFT_WHEEL in bits
    message.right_wheel = Overcurrents.RIGHT_WHEEL in bits
    message.driver_0 = Overcurrents.DRIVER_0 in bits
    message.driver_1 = Overcurrents.DRIVER_1 in bits
    message.driver_2 = Overcurrents.DRIVER_2 in bits


def song(message: Song, readings: Readings) -> None:
    """Fill in the number of the song and whether it plays (packets 36 and 37)."""
    message.number = readings.song_number
    message.playing = readings.song_playing


def cargo_bay(message: CargoBay, readings: Readings) -> None:
    """Fill in the inputs of the cargo bay connector (packets 32 and 33)."""
    bits = readings.digital_inputs
    message.input_0 = DigitalInputs.INPUT_0 in bits
    message.input_1 = DigitalInputs.INPUT_1 in bits
    message.input_2 = DigitalInputs.INPUT_2 in bits
    message.input_3 = DigitalInputs.INPUT_3 in bits
    message.baud_rate_pin = DigitalInputs.BAUD_RATE_CHANGE in bits
    message.analog = readings.analog_signal * VOLTS_PER_STEP


def age(stamp: Time, nanoseconds: int) -> float:
    """Return the seconds from a stamp to a time in nanoseconds; 0 if the stamp is not set."""
    stamped = stamp.sec * NANOSECONDS + stamp.nanosec
    return (nanoseconds - stamped) / NANOSECONDS if stamped else 0.0


def led_bits(play: bool, advance: bool) -> LedBits:
    """Return the bits of the LEDs that are on."""
    return LedBits(LedBits.PLAY * play | LedBits.ADVANCE * advance)


def output_bits(*outputs: bool) -> OutputBits:
    """Return the bits of the digital outputs 0, 1 and 2 that are high."""
    return OutputBits(sum(bit for bit, high in zip(OutputBits, outputs) if high))


def script(text: str, code: bytes) -> Script:
    """Return a script from text or from bytes; ValueError says what is wrong."""
    if text and code:
        raise ValueError('both text and code are given: leave one empty')
    return parse_script(text) if text else Script(script=code)


def script_text(code: bytes) -> str:
    """Return the commands of a script, one a line; '' if its bytes are no commands."""
    try:
        return format_commands(commands_of(Script(script=code)))
    except ValueError:
        return ''
