# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The health of driver and robot as REP 107 diagnostics.

OK: nothing to do. WARN: look at it soon, or nothing is known since no robot answers. ERROR: it
does not work. STALE is left to aggregators, which say it of a node that reports nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import isnan

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import BatteryState

from .. import __version__, oi
from ..driver import BatteryLevel, Charging, Health, LinkCounts
from ..driver.goals.motions import bumps
from ..odometry import Knowledge, Known
from . import messages
from .messages import Values
from .parameters import Parameters

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
HOT, TOO_HOT = 45, 60
"""Degrees Celsius of the battery that are unusual while charging, and dangerous (guess)."""
CHARGE = ('battery_charge', 'battery_capacity')
BATTERY = ('charging_state', 'voltage', 'current', 'battery_temperature')
TOUCHED = ('bumps_and_wheel_drops', 'overcurrents', 'charging_sources')
LINK, PARAMETERS = 'serial link', 'parameters'
"""Names of two statuses, for programs that read them."""


def status(name: str, level: bytes, message: str, values: Values) -> DiagnosticStatus:
    """Return a status; the node puts its own name before this one, and adds its hardware id."""
    return DiagnosticStatus(
        level=level, name=name, message=message,
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


def serial_link(health: Health, port: str, before: LinkCounts) -> DiagnosticStatus:
    """Say how well the line works; `before` are the counts of a second ago."""
    counts = health.counts
    faults = counts.checksum_failures - before.checksum_failures
    faults += counts.implausible_frames - before.implausible_frames
    faults += counts.impossible_jumps - before.impossible_jumps
    garbage = counts.garbage_bytes - before.garbage_bytes
    level, message = OK, 'frames arrive'
    if not health.answered:
        level, message = ERROR, health.line_problem or health.activity.value
    elif health.line_problem is not None:
        level, message = WARN, health.line_problem
    elif faults or garbage:
        level, message = WARN, 'bytes arrive damaged: look at plug, cable and motors nearby'
    age = health.frame_age
    return status(LINK, level, message, {
        'port': port, 'frames per second': float(counts.frames - before.frames),
        'damaged frames': faults, 'garbage bytes': garbage,
        'odd values': counts.odd_values - before.odd_values,
        'odd packets': _odd(health.odd) or 'none',
        'seconds since a frame': 'never' if age is None else round(age, 2),
        'silences since start': counts.silences,
        'checksum': health.checksum.value if health.checksum else 'not known yet',
        'bytes spare in a slot': health.spare_bytes})


def _odd(values: Mapping[str, int]) -> str:
    return ', '.join(f'{name.replace("_", " ")} = {value}' for name, value in values.items())


def mode(health: Health) -> DiagnosticStatus:
    """Say whether the robot is in the wanted mode, and why not."""
    known = health.mode
    actual = 'unknown' if known.actual is None else known.actual.name
    level, message = OK, actual
    if known.actual is None and not known.unknown:
        level, message = WARN, known.reason
    elif known.actual != known.wanted:
        level, message = OK, f'{actual}, entering {known.wanted.name}'
        if known.reason:
            level, message = WARN, f'{actual} instead of {known.wanted.name}: {known.reason}'
    return status('mode', level, message, {
        'mode': actual, 'wanted': known.wanted.name, 'reason': known.reason})


def safety(health: Health) -> DiagnosticStatus:
    """Say what is in the robot's way, or keeps it from driving."""
    readings = health.readings
    if not health.answered or not readings.has(*TOUCHED):
        return status('safety', WARN, 'no robot answers', {})
    hazards = ', '.join(cause.value for cause in health.hazards)
    overcurrents = [bit.name or '' for bit in oi.Overcurrents if readings.overcurrents & bit]
    level, message = OK, 'nothing in the way'
    if any(wheel.endswith('WHEEL') for wheel in overcurrents):
        level, message = ERROR, 'a wheel is blocked: free it'
    elif overcurrents:
        level, message = WARN, 'a low side driver draws too much current: switch it off'
    elif hazards:
        level, message = WARN, hazards
    elif health.mode.actual is oi.Mode.FULL:
        message = 'Full mode: the robot does not stop at cliffs by itself'
    return status('safety', level, message, {
        'bumper': 'pressed' if bumps(readings) else 'free', 'hazards': hazards or 'none',
        'overcurrent': ', '.join(overcurrents).lower() or 'none'})


def battery(health: Health, *, charge_known: bool) -> DiagnosticStatus:
    """Say whether the battery lasts, and whether it is charged where it could be."""
    readings = health.readings
    if not health.answered or not readings.has(
            'battery_capacity', 'charging_sources', 'oi_mode'):
        return status('battery', WARN, 'no robot answers', {})
    state = BatteryState()
    messages.battery_state(state, readings, charge_known=charge_known)
    charge, temperature = state.percentage, state.temperature
    level, message = _battery(health, charge, temperature)
    odd = {each: value for each, value in health.odd.items()
           if each in BATTERY or charge_known and each in CHARGE}
    if charge_known and isnan(charge) and not odd and readings.number('battery_charge', 0):
        odd = {each: readings.number(each, 0) for each in CHARGE}
    if odd and level == OK:
        level, message = WARN, f'not known: {_odd(odd)}, which no battery has'
    charging = readings.charging_state
    return status('battery', level, message, {
        'voltage (V)': _known(state.voltage, 3), 'current (A)': _known(state.current, 3),
        'charge (%)': _known(100 * charge), 'temperature (C)': _known(temperature, 1),
        'charging': 'not known' if charging is None else charging.name.lower()})


def _known(number: float, digits: int | None = None) -> float | str:
    return 'not known' if isnan(number) else round(number, digits)


def _battery(health: Health, charge: float, temperature: float) -> tuple[bytes, str]:
    readings, mode, charging = health.readings, health.mode, health.charging
    if readings.charging_state == oi.ChargingState.FAULT:
        return ERROR, 'charging fault: check battery and charger'
    if temperature >= TOO_HOT:
        return ERROR, f'{temperature:.0f} degrees Celsius: switch it off'
    fails = f'; it {charging.value}' if charging is Charging.FAILS else ''
    if fails and mode.can_drive:
        fails += f' in {mode.name}: call set_mode with PASSIVE'
    if health.battery is BatteryLevel.EMPTY:
        return ERROR, f'empty: charge it now{fails}'
    if health.battery is BatteryLevel.LOW:
        return WARN, f'low: charge it soon{fails}'
    if temperature >= HOT:
        return WARN, f'hot, {temperature:.0f} degrees Celsius: let it cool'
    if fails:
        return WARN, f'on the charger{fails}'
    if charging is not Charging.NO_CHARGER:
        return OK, f'on the charger; it {charging.value}'
    return OK, 'charge not known' if isnan(charge) else 'charged enough'


def driver(
    health: Health, stale_commands: int, publishers: Sequence[str],
) -> DiagnosticStatus:
    """Say what the driver is doing; `publishers` of `cmd_vel` are full names of nodes."""
    level, message = OK, health.activity.value
    if health.ignores_commands:
        level, message = ERROR, 'the robot ignores commands: switch it off and on'
    elif health.suspects_commands:
        level, message = WARN, 'the robot shows no sign that it obeys: does it wait (a script)?'
    elif health.answered and health.busy is not None:
        level, message = WARN, health.busy
    return status('driver', level, message, {
        'stale commands dropped': stale_commands,
        'cmd_vel publishers': ', '.join(publishers) or 'none',
        'songs stored': ', '.join(map(str, health.songs)) or 'none'})


def odometry(health: Health) -> DiagnosticStatus:
    """Say what the odometry has learned of this robot, and how sure it is."""
    robot, gyro = health.robot, health.gyro
    level, message = OK, 'nothing learned yet'
    if robot is not None:
        message = 'knows this robot' if robot.certain else 'learns this robot: drive and turn'
    if gyro is not None and gyro.problem is not None:
        level, message = WARN, f'the gyro is not used: {gyro.problem}'
    elif gyro is not None and gyro.slips_now:
        level, message = WARN, 'wheels and gyro disagree: wheels slip, or somebody turns the robot'
    return status('odometry', level, message, {
        **({} if robot is None else numbers_of(robot)),
        **({} if gyro is None else {'gyro': gyro.problem or 'used', 'slips': gyro.slips})})


def numbers_of(robot: Knowledge) -> dict[str, object]:
    """Return what is known of a robot, by the names of the file of `odometry_model`."""
    rounding, sign = robot.likeliest
    known = {name: value for name, value in vars(robot).items() if isinstance(value, Known)}
    return {
        'rounding': f'{rounding.value} ({robot.rounding[rounding]:.1%} sure)',
        'encoder_sign': f'{sign.value} ({robot.encoder_sign[sign]:.1%} sure)',
        **{name: f'{value:.4g} +- {deviation:.2g}' for name, (value, deviation) in known.items()},
        'readings': robot.readings}


def parameters(values: Parameters) -> DiagnosticStatus:
    """Report version and parameters, so that every recording holds them."""
    return status(PARAMETERS, OK, f'version {__version__}', {
        'version': __version__, **asdict(values)})


def of_driver(message: DiagnosticArray, namespace: str) -> dict[str, DiagnosticStatus]:
    """
    Return the statuses of the driver in a namespace, by their names without its own.

    They are none in a message of another node: all nodes share the topic.
    """
    for each in message.status:
        node, _, about = each.name.rpartition(': ')
        if about == LINK and node.rpartition('/')[0] == namespace:
            prefix = f'{node}: '
            return {own.name.removeprefix(prefix): own for own in message.status
                    if own.name.startswith(prefix)}
    return {}
