# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The node's parameters, each declared once: the field is the parameter.

Name, type and default are the dataclass field's; description, range and whether it may be set
while the node runs are in its metadata. `declare` declares them to ROS in one loop.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from math import isfinite, radians
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..driver import LowBatteryAction, MotionLimits, Settings
from ..driver.stream import StreamPlan
from ..odometry import Geometry, GyroSettings
from ..oi import BaudCode, Mode
from ..oi.codes import START_BAUDS
from ..robot import TOP_SPEED
from .topics import ALL_TOPICS

START_MODES = {mode.name.lower(): mode for mode in (Mode.PASSIVE, Mode.SAFE, Mode.FULL)}
BAUDS = tuple(code.rate for code in BaudCode)


def parameter(
    default: Any, description: str, *, low: float | None = None, high: float | None = None,
    choices: tuple[Any, ...] = (), live: bool = False,
) -> Any:
    """Declare one parameter; a live one may be set while the node runs, others at its start."""
    return field(default=default, metadata={
        'description': description, 'low': low, 'high': high, 'choices': choices, 'live': live})


@dataclass(frozen=True)
class Parameters:
    """All parameters of the node; SI units."""

    port: str = parameter(
        '/dev/ttyUSB0', 'Serial device of the robot, or a pyserial URL (socket://HOST:PORT)')
    baud: int = parameter(
        Settings.baud, 'Baud rate, bit/s; 0 looks for the robot at 57600, 19200 and 115200',
        choices=(0, *BAUDS))
    mode_on_start: str = parameter(
        Settings.mode_on_start.name.lower(), 'Mode that the robot is put into',
        choices=tuple(START_MODES))
    mode_on_exit: str = parameter(
        Settings.mode_on_exit.name.lower(),
        'Mode that the robot is left in; only in passive does it charge',
        choices=tuple(START_MODES))
    recover_mode: bool = parameter(
        Settings.recover_mode, 'Whether a fresh velocity command brings back a mode that a cliff, '
        'a wheel drop or a charger ended, once its cause has been gone for a second')
    cmd_vel_timeout: float = parameter(
        MotionLimits.timeout, 'Watchdog: seconds after the last velocity command at which the '
        'wheels stop', low=0.05, high=10.0, live=True)
    cmd_vel_type: str = parameter(
        'auto', 'Message of cmd_vel: geometry_msgs/Twist, TwistStamped, or auto: Twist until all '
        'publishers send TwistStamped, and back', choices=('auto', 'twist', 'stamped'))
    wheel_separation: float = parameter(
        MotionLimits.wheel_separation, 'Distance between the wheels, m', low=0.1, high=0.5)
    max_wheel_speed: float = parameter(
        MotionLimits.max_wheel_speed, 'Highest speed of either wheel, m/s', low=0.0,
        high=TOP_SPEED, live=True)
    max_linear_acceleration: float = parameter(
        MotionLimits.linear_acceleration, 'Maximum linear acceleration, m/s2; 0: no '
        'limit. Not applied on timeout or `stop`', low=0.0, high=10.0, live=True)
    max_angular_acceleration: float = parameter(
        MotionLimits.angular_acceleration,
        'Maximum angular acceleration, rad/s2; 0: no limit', low=0.0, high=100.0, live=True)
    cmd_vel_interrupts: bool = parameter(
        MotionLimits.commands_interrupt, 'Whether a velocity command that is not zero ends the '
        'goal of an action that runs; else it is ignored meanwhile', live=True)
    goal_pose: bool = parameter(
        False, 'Whether a message on `goal_pose` (geometry_msgs/PoseStamped, "2D Goal Pose" of '
        'RViz) starts `navigate_to_position`; off where Nav2 follows it')
    bump_stop: str = parameter(
        'none', 'What a pressed bumper holds back of velocity commands: nothing, or all that '
        'drives forward; backing and turning stay possible',
        choices=('none', 'forward'), live=True)
    contact_persistence: float = parameter(
        2.0, 'Seconds for which `contacts` keeps what was felt, unless the robot moves away',
        low=0.0, high=60.0, live=True)
    linear_scale: float = parameter(
        1.0, 'True distance over the distance that the robot reports', low=0.5, high=2.0)
    angular_scale: float = parameter(
        1.0, 'True angle over the angle that the robot reports', low=0.5, high=2.0)
    odometry_window: float = parameter(
        Settings.odometry_window, 'Seconds, about, between readings of distance and angle, of '
        'which the robot drops the fractions', low=0.1, high=10.0)
    odometry_model: str = parameter(
        '', 'File of what the odometry knows of this robot (YAML, of `create_check` or of this '
        'node): read at start, written at the end and by `save_odometry_model`; where it does '
        'not exist, it is made. Empty: none')
    gyro: str = parameter(
        'none', 'Gyro on the analog input of the cargo bay: its turning is published on '
        '`imu/data`, and the odometry uses it (docs/gyro.md). Needs 57600 baud or more',
        choices=('none', 'analog'))
    gyro_scale: float = parameter(
        80.0, 'Degrees a second for each volt of that gyro, by its data sheet: sign and exact '
        'value are learned, and kept in `odometry_model`', low=-1000.0, high=1000.0)
    gyro_range: float = parameter(
        150.0, 'Degrees a second up to which it measures', low=1.0, high=5000.0)
    odom_frame: str = parameter('odom', 'Frame of the odometry')
    base_frame: str = parameter('base_footprint', 'Frame of the robot, on the floor')
    dock_pose: str = parameter(
        '', 'Where the robot is when it stands on its dock, in `odom_frame`: x, y (m) and yaw '
        "(rad) as '1.0 2.0 3.14'. Each time it docks, the odometry goes on from there. Empty: not "
        'known')
    publish_tf: bool = parameter(True, 'Whether to publish odom_frame -> base_frame on /tf')
    sensor_rate: float = parameter(
        20.0, 'Rate at which sensor topics are published when nothing changes, Hz',
        low=0.1, high=66.0, live=True)
    odom_rate: float = parameter(
        0.0, 'Highest rate of `odom`, `/tf` and `joint_states`, Hz; 0: with every frame (66.7). '
        'The odometry uses every frame at any rate', low=0.0, high=66.0, live=True)
    battery_technology: str = parameter(
        'nimh', 'Battery in the robot; the charge of an alkaline pack is not known',
        choices=('nimh', 'alkaline'))
    battery_low: float = parameter(
        Settings.battery_low, 'Voltage below which the battery is reported as low, V; a charge '
        'below 20 % is, too', low=0.0, high=20.0)
    battery_empty: float = parameter(
        Settings.battery_empty, 'Voltage below which it is reported as nearly empty, V; a charge '
        'below 5 % is, too', low=0.0, high=20.0)
    low_battery_action: str = parameter(
        Settings.low_battery_action.value, 'What to do when the battery is nearly empty: nothing, '
        'stop in Passive, or look for the dock',
        choices=tuple(action.value for action in LowBatteryAction))
    reset_when_not_charging: bool = parameter(
        Settings.reset_when_not_charging, 'Whether a robot that does not charge on its Home Base '
        'is restarted (opcode 7)')
    output_names: tuple[str, ...] = parameter(
        Settings.output_names, 'Names of the digital outputs of the cargo bay, for '
        '`set_digital_output`; of the first ones where there are fewer')
    dead_man: bool = parameter(
        True, 'Whether a process of its own stops the robot when the node dies')
    capture: str = parameter(
        '', 'File to write every byte of the serial line to, both ways, with times; nothing is '
        'overwritten: where it exists, a number is added to its name')

    def settings(self) -> Settings:
        return Settings(
            baud=self.baud, mode_on_start=START_MODES[self.mode_on_start],
            mode_on_exit=START_MODES[self.mode_on_exit], recover_mode=self.recover_mode,
            battery_low=self.battery_low, battery_empty=self.battery_empty,
            charge_known=self.charge_known,
            low_battery_action=LowBatteryAction(self.low_battery_action),
            reset_when_not_charging=self.reset_when_not_charging,
            dock_pose=pose(self.dock_pose), output_names=self.output_names,
            odometry_window=self.odometry_window, limits=self.limits(),
            gyro=None if self.gyro == 'none' else GyroSettings(
                radians(self.gyro_scale), radians(self.gyro_range)),
            geometry=Geometry(
                wheel_separation=self.wheel_separation, linear_scale=self.linear_scale,
                angular_scale=self.angular_scale))

    @property
    def charge_known(self) -> bool:
        """Whether the battery's charge is known."""
        return self.battery_technology == 'nimh'

    def limits(self) -> MotionLimits:
        """Return the limits of the motion, which may change while the node runs."""
        return MotionLimits(
            wheel_separation=self.wheel_separation, max_wheel_speed=self.max_wheel_speed,
            timeout=self.cmd_vel_timeout,
            linear_acceleration=self.max_linear_acceleration,
            angular_acceleration=self.max_angular_acceleration,
            bump_stop=self.bump_stop == 'forward',
            commands_interrupt=self.cmd_vel_interrupts)


def pose(text: str) -> tuple[float, float, float] | None:
    """Return x, y and yaw from a text of three numbers; None: an empty one; ValueError: others."""
    if not text.strip():
        return None
    x, y, yaw = map(float, text.replace(',', ' ').split())
    if not all(map(isfinite, (x, y, yaw))):
        raise ValueError
    return x, y, yaw


DECLARED = Parameters.__dataclass_fields__
OF_ROS = ('use_sim_time', 'start_type_description_service')
"""Beginnings of the names of parameters that every ROS node has."""

QOS_OVERRIDES = 'qos_overrides.'
QOS_CHOICES = {'history': ('keep_last', 'keep_all'), 'reliability': ('reliable', 'best_effort')}
DEPTHS = range(1, 1 << 31)
"""What the middleware can count."""

TAKES = {float: 'a number', int: 'a whole number', bool: 'true or false', str: 'text',
         tuple: 'a list of names'}


def descriptor(name: str) -> ParameterDescriptor:
    facts = DECLARED[name].metadata
    described = ParameterDescriptor(description=facts['description'], read_only=not facts['live'])
    if facts['low'] is not None:
        described.floating_point_range = [
            FloatingPointRange(from_value=facts['low'], to_value=facts['high'])]
    if facts['choices']:
        described.additional_constraints = f'one of {listed(facts["choices"])}'
    return described


def declare(node: Node) -> Parameters:
    """
    Declare all parameters; ValueError or ParameterException says which value is wrong and why.

    The node must declare what it is given by itself; that is declared anew, with descriptions.
    """
    given = {name: node.get_parameter(name).value for name in node.get_parameters_by_prefix('')}
    policies = overridable_qos(node)
    for name in sorted(given.keys() - DECLARED.keys()):
        if name in policies:  # its publisher declares it
            if reason := qos_refusal(name, policies[name], given[name]):
                raise ValueError(reason)
        elif name.startswith(QOS_OVERRIDES):
            node.get_logger().warning(
                f'parameter {name} cannot be overridden and is ignored: of a publisher of this '
                'node, history, depth and reliability can; a transient local one stays reliable')
        elif name.startswith(OF_ROS):
            continue
        else:
            meant = suggestion(name, {each: each for each in DECLARED})
            node.get_logger().warning(f'parameter {name} is unknown and ignored{meant}')
        node.undeclare_parameter(name)
    values = {}
    for name in DECLARED:
        default = _default(name)
        value = _as_declared(name, given.get(name, default))
        if type(value) is not type(default):
            raise ValueError(wrong_type(name, value))
        if reason := refusal(name, value):
            raise ValueError(reason)
        if name in given:
            node.undeclare_parameter(name)
        values[name] = node.declare_parameter(
            name, value, descriptor(name), ignore_override=True).value
    parameters = Parameters(**values)
    if reason := contradiction(parameters):
        raise ValueError(reason)
    return parameters


def overridable_qos(node: Node) -> dict[str, str]:
    """Return what may be overridden of the publishers' QoS: the policy, by its parameter."""
    return {f'{QOS_OVERRIDES}{node.resolve_topic_name(topic.name)}.publisher.{policy}': policy
            for topic in ALL_TOPICS
            for policy in (kind.name.lower() for kind in topic.overridable)}


def qos_refusal(name: str, policy: str, value: Any) -> str | None:
    """Say why a QoS override is not allowed; None where it is."""
    if policy == 'depth':
        fits, words = type(value) is int and value in DEPTHS, f'{DEPTHS[0]} to {DEPTHS[-1]}'
    else:
        fits, words = value in QOS_CHOICES[policy], listed(QOS_CHOICES[policy])
    return None if fits else f'parameter {name} = {value!r}; allowed: {words}'


def as_declared(parameters: list[Parameter]) -> list[Parameter]:
    """Accept what people write for the values of parameters, such as 1 for 1.0."""
    return [Parameter(each.name, value=_as_declared(each.name, each.value))
            for each in parameters]


def _as_declared(name: str, value: Any) -> Any:
    """Return a whole number as float, and names with those that were left out."""
    default = _default(name)
    if isinstance(default, tuple) and isinstance(value, list | tuple) and all(
            isinstance(each, str) for each in value):
        return (*value, *default[len(value):])
    return float(value) if type(value) is int and type(default) is float else value


def check(parameters: list[Parameter]) -> SetParametersResult:
    """Refuse new values that are not allowed; ROS has checked their types."""
    reasons = [reason for parameter in parameters if parameter.name in DECLARED
               and (reason := refusal(parameter.name, parameter.value))]
    return SetParametersResult(successful=not reasons, reason='; '.join(reasons))


def refusal(name: str, value: Any) -> str | None:
    """Say why a value is not allowed, but for its range, which ROS checks; None where it is."""
    choices = DECLARED[name].metadata['choices']
    if choices and value not in choices:
        return f'parameter {name} = {value!r}; allowed: {listed(choices)}'
    if value == '' and _default(name) != '':
        return f'parameter {name} is empty: give a value, or leave it out'
    if isinstance(value, tuple):
        most = len(_default(name))
        if len(value) > most:
            return f'parameter {name} has {len(value)} names; allowed: up to {most}'
        if '' in value:
            return f'parameter {name} has an empty name: write {_default(name)[value.index("")]}'
        twice = [each for each in value if value.count(each) > 1]
        if twice:
            return f'parameter {name} has {twice[0]!r} twice: give each a name of its own'
    if name == 'dock_pose':
        try:
            pose(value)
        except ValueError:
            return (f"parameter dock_pose = {value!r}; allowed: x, y (m) and yaw (rad) as "
                    "'1.0 2.0 3.14', or an empty text")
    if name.endswith('_frame') and value.startswith('/'):
        return (f"parameter {name} = {value!r}; tf2 takes no leading '/': "
                f"write {value.lstrip('/')!r}")
    return None


def contradiction(parameters: Parameters) -> str | None:
    """Say which values contradict each other; None where none do."""
    if parameters.odom_frame == parameters.base_frame:
        return (f'parameters odom_frame and base_frame are both {parameters.odom_frame!r}: a '
                'frame cannot move in itself; give them different names')
    if parameters.battery_low < parameters.battery_empty:
        return (f'parameter battery_low = {parameters.battery_low} is below battery_empty = '
                f'{parameters.battery_empty}: a battery is low before it is empty')
    if parameters.gyro == 'none':
        return None
    if not parameters.gyro_scale:
        return "parameter gyro_scale = 0: give the data sheet's degrees a second for each volt"
    everything = StreamPlan(START_BAUDS[0]).full.budget(parameters.baud or START_BAUDS[0])
    if not everything.fits:
        return (f'parameters gyro and baud: {parameters.baud} baud carries {everything.capacity} '
                f'bytes in a slot, and a frame that always has packet 33 has {everything.size}: '
                f'use {START_BAUDS[0]} baud')
    return None


def wrong_type(name: str, value: Any) -> str:
    """Say what a parameter takes, and how to write such a value."""
    default = _default(name)
    takes = TAKES[type(default)]
    advice = f'write {written(default)}, for example'
    if isinstance(default, str) and isinstance(value, bool | int | float):
        choices = DECLARED[name].metadata['choices']
        advice = (f'allowed: {listed(choices)}' if choices else
                  f"""write '{value}' with its quotes (after -p: {name}:="'{value}'")""")
    elif isinstance(default, str) and isinstance(value, Iterable):
        advice = f"write '{' '.join(map(str, value))}' with its quotes"
    return f'parameter {name} = {written(value)} is of the wrong type: it takes {takes}; {advice}'


def written(value: Any) -> str:
    """Return a value as people write it in YAML."""
    if isinstance(value, tuple):
        return f'[{", ".join(value)}]'
    return str(value).lower() if isinstance(value, bool) else repr(value)


def shown(default: Any) -> str:
    """Return a default as help and tables show it."""
    return default or "''" if isinstance(default, str) else written(default)


def suggestion(name: str, known: Mapping[str, str]) -> str:
    """Return a question for the nearest known name, as its text; empty where none is near."""
    found = get_close_matches(name, known, 1)
    return f': did you mean {known[found[0]]}?' if found else ''


def allowed(facts: Mapping[str, Any]) -> str:
    """Return the allowed values of a parameter, by its metadata; empty: all."""
    if facts['low'] is not None:
        return f'{facts["low"]} to {facts["high"]}'
    return listed(facts['choices'])


def listed(choices: tuple[Any, ...]) -> str:
    """Return allowed values as people read them."""
    return ', '.join(str(choice) for choice in choices)


def _default(name: str) -> Any:
    return DECLARED[name].default if name in DECLARED else None
