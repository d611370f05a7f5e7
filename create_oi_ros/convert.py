"""Readings and estimates to ROS messages, requests to the core's terms, in SI units. Pure."""

from math import cos, nan, sin

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
from geometry_msgs.msg import Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, JointState
from std_msgs.msg import Header

from . import oi
from .driver import ModeStatus
from .odometry import Estimate
from .oi import (
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
from .oi.script import commands_of
from .oi.text import format_commands, parse_script

MILLI = 0.001
VOLTS_PER_STEP = 5 / 1023
"""Of the analog input (manual: Cargo Bay Analog Signal)."""
NANOSECONDS = 1_000_000_000
NOT_MEASURED = 1e6
"""Variance of what a robot on a floor cannot measure: height, roll and pitch."""
POSE_AXES, TWIST_AXES = (0, 1, 5), (0, 5)
"""Places of x, y, yaw and of forward and turning speed among the six axes of a covariance."""
WHEEL_JOINTS = ('left_wheel_joint', 'right_wheel_joint')


def time(nanoseconds: int) -> Time:
    """Return a ROS time from nanoseconds since the epoch."""
    seconds, rest = divmod(nanoseconds, NANOSECONDS)
    return Time(sec=seconds, nanosec=rest)


def header(frame: str, stamp: Time) -> Header:
    """Return a header."""
    return Header(frame_id=frame, stamp=stamp)


def quaternion(yaw: float) -> Quaternion:
    """Return a rotation about the vertical."""
    return Quaternion(z=sin(yaw / 2), w=cos(yaw / 2))


def covariance(axes: tuple[int, ...], known: tuple[float, ...]) -> list[float]:
    """Spread a small row-major covariance over the six axes of ROS."""
    spread = [0.0] * 36
    for axis in range(6):
        spread[7 * axis] = NOT_MEASURED
    for row, row_axis in enumerate(axes):
        for column, column_axis in enumerate(axes):
            spread[6 * row_axis + column_axis] = known[row * len(axes) + column]
    return spread


def odometry(estimate: Estimate, header: Header, base_frame: str) -> Odometry:
    """Pose in the frame of the header, twist in the base frame (REP 105, REP 103)."""
    message = Odometry(header=header, child_frame_id=base_frame)
    message.pose.pose.position.x = estimate.x
    message.pose.pose.position.y = estimate.y
    message.pose.pose.orientation = quaternion(estimate.yaw)
    message.pose.covariance = covariance(POSE_AXES, estimate.pose_covariance)
    message.twist.twist.linear.x = estimate.linear
    message.twist.twist.angular.z = estimate.angular
    linear, angular = estimate.twist_covariance
    message.twist.covariance = covariance(TWIST_AXES, (linear, 0.0, 0.0, angular))
    return message


def transform(estimate: Estimate, header: Header, base_frame: str) -> TransformStamped:
    """Return the base frame's place in the frame of the header."""
    message = TransformStamped(header=header, child_frame_id=base_frame)
    message.transform.translation.x = estimate.x
    message.transform.translation.y = estimate.y
    message.transform.rotation = quaternion(estimate.yaw)
    return message


def joint_states(estimate: Estimate, header: Header) -> JointState:
    """Return the wheels' measured angles, rad, and speeds, rad/s."""
    return JointState(
        header=header, name=WHEEL_JOINTS,
        position=[estimate.left_wheel, estimate.right_wheel],
        velocity=[estimate.left_wheel_speed, estimate.right_wheel_speed])


def bumper(readings: Readings, header: Header) -> Bumper:
    """Return the bumper's two halves (packet 7)."""
    bits = readings.bumps_and_wheel_drops
    return Bumper(
        header=header, left=bool(bits & BumpsAndWheelDrops.BUMP_LEFT),
        right=bool(bits & BumpsAndWheelDrops.BUMP_RIGHT))


def wheel_drop(readings: Readings, header: Header) -> WheelDrop:
    """Return which wheels hang (packet 7)."""
    bits = readings.bumps_and_wheel_drops
    return WheelDrop(
        header=header, left=bool(bits & BumpsAndWheelDrops.WHEEL_DROP_LEFT),
        right=bool(bits & BumpsAndWheelDrops.WHEEL_DROP_RIGHT),
        caster=bool(bits & BumpsAndWheelDrops.WHEEL_DROP_CASTER))


def cliff(readings: Readings, header: Header) -> Cliff:
    """Return the cliff sensors and their signals (packets 9 to 12 and 28 to 31)."""
    return Cliff(
        header=header,
        left=readings.cliff_left, front_left=readings.cliff_front_left,
        front_right=readings.cliff_front_right, right=readings.cliff_right,
        left_signal=readings.cliff_left_signal,
        front_left_signal=readings.cliff_front_left_signal,
        front_right_signal=readings.cliff_front_right_signal,
        right_signal=readings.cliff_right_signal)


CHARGING = {
    ChargingState.RECONDITIONING: BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    ChargingState.FULL_CHARGING: BatteryState.POWER_SUPPLY_STATUS_CHARGING,
    ChargingState.TRICKLE: BatteryState.POWER_SUPPLY_STATUS_FULL,
    ChargingState.WAITING: BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING,
    ChargingState.FAULT: BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING,
}
"""What a charging state with a source means; without one the battery is discharging."""


def battery_state(readings: Readings, header: Header, *, charge_known: bool) -> BatteryState:
    """
    Return the battery, true to its message: NaN for what is not known (packets 21 to 26).

    The charge is not known with the alkaline pack (manual: Battery Charge). Real robots may
    report a charge above the capacity, and a capacity of 0.
    """
    status = CHARGING.get(readings.charging_state, BatteryState.POWER_SUPPLY_STATUS_DISCHARGING)
    if readings.charging_state == ChargingState.NOT_CHARGING and readings.charging_sources:
        status = BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING
    faulty = readings.charging_state == ChargingState.FAULT
    charge, capacity = nan, nan
    if charge_known and readings.battery_capacity > 0:
        charge = readings.battery_charge * MILLI
        capacity = readings.battery_capacity * MILLI
    return BatteryState(
        header=header, voltage=readings.voltage * MILLI, current=readings.current * MILLI,
        temperature=float(readings.battery_temperature), charge=charge, capacity=capacity,
        design_capacity=nan, percentage=min(charge / capacity, 1.0),
        power_supply_status=status,
        power_supply_health=(
            BatteryState.POWER_SUPPLY_HEALTH_UNSPEC_FAILURE if faulty
            else BatteryState.POWER_SUPPLY_HEALTH_UNKNOWN),
        power_supply_technology=(
            BatteryState.POWER_SUPPLY_TECHNOLOGY_NIMH if charge_known
            else BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN),
        present=True)


def mode(status: ModeStatus, header: Header) -> Mode:
    """Return the actual and the wanted mode, and why they differ."""
    return Mode(
        header=header, mode=Mode.UNKNOWN if status.actual is None else status.actual,
        wanted=status.wanted, reason=status.reason)


def wall(readings: Readings, header: Header) -> Wall:
    """Return the wall sensor and the virtual wall (packets 8, 13 and 27)."""
    return Wall(
        header=header, wall=readings.wall, virtual_wall=readings.virtual_wall,
        signal=readings.wall_signal)


def buttons(readings: Readings, header: Header) -> Buttons:
    """Return which buttons are pressed (packet 18)."""
    return Buttons(
        header=header, play=bool(readings.buttons & oi.Buttons.PLAY),
        advance=bool(readings.buttons & oi.Buttons.ADVANCE))


def ir_omni(readings: Readings, header: Header) -> IrOmni:
    """Return the infrared character that is received, and its name (packet 17)."""
    character = readings.infrared
    name = Infrared(character).name.lower() if character in list(Infrared) else ''
    return IrOmni(header=header, character=character, name=name)


def charging(readings: Readings, header: Header) -> Charging:
    """Return the charging state and the sources (packets 21 and 34)."""
    sources = readings.charging_sources
    return Charging(
        header=header, state=readings.charging_state,
        internal_charger=bool(sources & ChargingSources.INTERNAL_CHARGER),
        home_base=bool(sources & ChargingSources.HOME_BASE))


def overcurrent(readings: Readings, header: Header) -> Overcurrent:
    """Return what draws too much current (packet 14)."""
    bits = readings.overcurrents
    return Overcurrent(
        header=header, left_wheel=bool(bits & Overcurrents.LEFT_WHEEL),
        right_wheel=bool(bits & Overcurrents.RIGHT_WHEEL),
        driver_0=bool(bits & Overcurrents.DRIVER_0), driver_1=bool(bits & Overcurrents.DRIVER_1),
        driver_2=bool(bits & Overcurrents.DRIVER_2))


def song(readings: Readings, header: Header) -> Song:
    """Return the song that plays, or played last (packets 36 and 37)."""
    return Song(header=header, number=readings.song_number, playing=readings.song_playing)


def cargo_bay(readings: Readings, header: Header) -> CargoBay:
    """Return the inputs of the cargo bay connector (packets 32 and 33)."""
    bits = readings.digital_inputs
    return CargoBay(
        header=header, input_0=bool(bits & DigitalInputs.INPUT_0),
        input_1=bool(bits & DigitalInputs.INPUT_1), input_2=bool(bits & DigitalInputs.INPUT_2),
        input_3=bool(bits & DigitalInputs.INPUT_3),
        baud_rate_pin=bool(bits & DigitalInputs.BAUD_RATE_CHANGE),
        analog=readings.analog_signal * VOLTS_PER_STEP)


def age(stamp: Time, nanoseconds: int) -> float:
    """Return the seconds from a stamp to a time; 0 where there is no stamp."""
    stamped = stamp.sec * NANOSECONDS + stamp.nanosec
    return (nanoseconds - stamped) / NANOSECONDS if stamped else 0.0


def led_bits(play: bool, advance: bool) -> LedBits:
    """Return the bits of the LEDs that are on."""
    return LedBits(LedBits.PLAY * play | LedBits.ADVANCE * advance)


def output_bits(*outputs: bool) -> OutputBits:
    """Return the bits of the digital outputs 0, 1 and 2 that are high."""
    return OutputBits(sum(bit for bit, high in zip(OutputBits, outputs) if high))


def script(text: str, code: bytes) -> Script:
    """Return a script given as text or as bytes; ValueError says what is wrong with it."""
    if text and code:
        raise ValueError('both text and code are given: leave one empty')
    return parse_script(text) if text else Script(script=code)


def script_text(code: bytes) -> str:
    """Return a script's commands, a line each; '' where its bytes are no commands."""
    try:
        return format_commands(commands_of(Script(script=code)))
    except ValueError:
        return ''
