# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The node's parameters, each declared once: the field is the parameter.

Name, type and default are the dataclass field's; description, range and whether it may be set
while the node runs are in its metadata. `parameter_checks` declares them to ROS in one loop.
"""

from dataclasses import dataclass, field
from typing import Any

from ..driver import BatteryLimits, LowBatteryAction, MotionLimits, Settings
from ..odometry import Geometry
from ..oi import BaudCode, Mode
from ..robot import TOP_SPEED

START_MODES = {mode.name.lower(): mode for mode in (Mode.PASSIVE, Mode.SAFE, Mode.FULL)}
ACTIONS = {action.value: action for action in LowBatteryAction}
BUMP_STOPS = {'none': False, 'forward': True}
BAUDS = tuple(code.rate for code in BaudCode)


def parameter(
    default: Any, description: str, *, low: float | None = None, high: float | None = None,
    choices: tuple[Any, ...] = (), fixed: bool = False,
) -> Any:
    """Declare one parameter; a fixed one is read only when the node starts."""
    return field(default=default, metadata={
        'description': description, 'low': low, 'high': high, 'choices': choices, 'fixed': fixed})


@dataclass(frozen=True)
class Parameters:
    """All parameters of the node; SI units."""

    port: str = parameter(
        '/dev/ttyUSB0', 'Serial device of the robot, or a pyserial URL (socket://HOST:PORT)',
        fixed=True)
    baud: int = parameter(
        Settings.baud, 'Baud rate, bit/s; 0 looks for the robot at 57600, 19200, then the others',
        choices=(0, *BAUDS), fixed=True)
    mode_on_start: str = parameter(
        Settings.mode_on_start.name.lower(), 'Mode that the robot is put into',
        choices=tuple(START_MODES), fixed=True)
    mode_on_exit: str = parameter(
        Settings.mode_on_exit.name.lower(),
        'Mode that the robot is left in; only in passive does it charge',
        choices=tuple(START_MODES), fixed=True)
    recover_mode: bool = parameter(
        Settings.recover_mode, 'Whether a fresh velocity command brings back a mode that a cliff, '
        'a wheel drop or a charger ended, once its cause has been gone for a second', fixed=True)
    cmd_vel_timeout: float = parameter(
        MotionLimits.timeout, 'Seconds after the last velocity command at which the wheels stop',
        low=0.05, high=10.0)
    cmd_vel_type: str = parameter(
        'auto', 'Message of cmd_vel: geometry_msgs/Twist, TwistStamped, or auto: Twist until all '
        'publishers send TwistStamped, and back', choices=('auto', 'twist', 'stamped'),
        fixed=True)
    wheel_separation: float = parameter(
        MotionLimits.wheel_separation, 'Distance between the wheels, m', low=0.1, high=0.5,
        fixed=True)
    max_wheel_speed: float = parameter(
        MotionLimits.max_wheel_speed, 'Highest speed of either wheel, m/s', low=0.0,
        high=TOP_SPEED)
    max_linear_acceleration: float = parameter(
        MotionLimits.linear_acceleration, 'Highest change of the forward speed, m/s2; 0: no '
        'limit. The end of commands and `stop` know none', low=0.0, high=10.0)
    max_angular_acceleration: float = parameter(
        MotionLimits.angular_acceleration,
        'Highest change of the turning speed, rad/s2; 0: no limit', low=0.0, high=100.0)
    cmd_vel_interrupts: bool = parameter(
        MotionLimits.commands_interrupt, 'Whether a velocity command that is not zero ends the '
        'goal of an action that runs; else it is ignored meanwhile')
    bump_stop: str = parameter(
        'none', 'What a pressed bumper holds back of velocity commands: nothing, or all that '
        'drives forward; backing and turning stay possible', choices=tuple(BUMP_STOPS))
    contact_persistence: float = parameter(
        2.0, 'Seconds for which `contacts` keeps what was felt, unless the robot moves away',
        low=0.0, high=60.0)
    linear_scale: float = parameter(
        1.0, 'True distance over the distance that the robot reports', low=0.5, high=2.0,
        fixed=True)
    angular_scale: float = parameter(
        1.0, 'True angle over the angle that the robot reports', low=0.5, high=2.0, fixed=True)
    odometry_window: float = parameter(
        Settings.odometry_window, 'Seconds between readings of distance and angle, of which the '
        'robot drops the fractions; 0 reads them in every frame and believes them',
        low=0.0, high=10.0, fixed=True)
    odometry_model: str = parameter(
        '', 'File of what the odometry knows of this robot (YAML, of `create_check` or of this '
        'node): read at start, written at the end and by `save_odometry_model`; where it does '
        'not exist, it is made. Empty: none', fixed=True)
    odom_frame: str = parameter('odom', 'Frame of the odometry', fixed=True)
    base_frame: str = parameter('base_footprint', 'Frame of the robot, on the floor', fixed=True)
    publish_tf: bool = parameter(True, 'Whether to publish odom_frame -> base_frame on /tf',
                                 fixed=True)
    sensor_rate: float = parameter(
        20.0, 'Rate at which sensor topics are published when nothing changes, Hz',
        low=0.1, high=66.0)
    odom_rate: float = parameter(
        0.0, 'Highest rate of `odom`, `/tf` and `joint_states`, Hz; 0: with every frame (66.7). '
        'The odometry uses every frame at any rate; frames that say nothing new may wait until '
        'something is due', low=0.0, high=66.0)
    battery_technology: str = parameter(
        'nimh', 'Battery in the robot; the charge of an alkaline pack is not known',
        choices=('nimh', 'alkaline'), fixed=True)
    battery_low: float = parameter(
        BatteryLimits.low, 'Voltage below which the battery is reported as low, V',
        low=0.0, high=20.0, fixed=True)
    battery_empty: float = parameter(
        BatteryLimits.empty, 'Voltage below which it is reported as nearly empty, V',
        low=0.0, high=20.0, fixed=True)
    low_battery_action: str = parameter(
        BatteryLimits.action.value, 'What to do when the battery is nearly empty: nothing, stop '
        'in Passive, or look for the dock', choices=tuple(ACTIONS), fixed=True)
    reset_when_not_charging: bool = parameter(
        Settings.reset_when_not_charging, 'Whether a robot that does not charge on its Home Base '
        'is restarted (opcode 7)', fixed=True)
    dead_man: bool = parameter(
        True, 'Whether a process of its own stops the robot when the node dies', fixed=True)
    capture: str = parameter(
        '', 'File to write every byte of the serial line to, both ways, with times; nothing is '
        'overwritten: where it exists, a number is added to its name', fixed=True)

    def settings(self) -> Settings:
        """Return the settings of the driver."""
        return Settings(
            baud=self.baud, mode_on_start=START_MODES[self.mode_on_start],
            mode_on_exit=START_MODES[self.mode_on_exit], recover_mode=self.recover_mode,
            battery=BatteryLimits(
                low=self.battery_low, empty=self.battery_empty,
                action=ACTIONS[self.low_battery_action]),
            reset_when_not_charging=self.reset_when_not_charging,
            odometry_window=self.odometry_window, limits=self.limits(),
            geometry=Geometry(
                wheel_separation=self.wheel_separation, linear_scale=self.linear_scale,
                angular_scale=self.angular_scale))

    def periods(self) -> tuple[float, float]:
        """Return the seconds between two messages of a sensor, and between two of `odom`."""
        return 1 / self.sensor_rate, 1 / self.odom_rate if self.odom_rate else 0.0

    def limits(self) -> MotionLimits:
        """Return the limits of the motion, which may change while the node runs."""
        return MotionLimits(
            wheel_separation=self.wheel_separation, max_wheel_speed=self.max_wheel_speed,
            timeout=self.cmd_vel_timeout,
            linear_acceleration=self.max_linear_acceleration,
            angular_acceleration=self.max_angular_acceleration,
            bump_stop=BUMP_STOPS[self.bump_stop],
            commands_interrupt=self.cmd_vel_interrupts)
