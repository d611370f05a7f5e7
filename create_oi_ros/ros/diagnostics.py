"""
The state of driver and robot as REP 107 diagnostics.

OK: nothing to do. WARN: look at it soon. ERROR: it does not do its work. STALE: what is known is
old, for no robot answers.
"""

from dataclasses import asdict
from math import isnan

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from sensor_msgs.msg import BatteryState

from .. import __version__, oi
from ..driver import BatteryLevel, Driver, Link, LinkCounts
from . import messages as convert
from .parameters import Parameters

OK, WARN = DiagnosticStatus.OK, DiagnosticStatus.WARN
ERROR, STALE = DiagnosticStatus.ERROR, DiagnosticStatus.STALE
LOW, EMPTY = 0.2, 0.05
"""Parts of the capacity below which the battery is to be charged soon, or now."""
HOT, TOO_HOT = 45, 60
"""Degrees Celsius of the battery that are unusual while charging, and dangerous (guess)."""
CHARGED = (oi.ChargingState.FULL_CHARGING, oi.ChargingState.TRICKLE,
           oi.ChargingState.RECONDITIONING, oi.ChargingState.WAITING)
TOUCHED = ('bumps_and_wheel_drops', 'overcurrents', 'charging_sources')
Values = dict[str, object]
Verdict = tuple[bytes, str]
"""Level and message."""


def status(name: str, level: bytes, message: str, values: Values) -> DiagnosticStatus:
    """Make one status."""
    return DiagnosticStatus(
        level=level, name=name, message=message, hardware_id='iRobot Create',
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])


def serial_link(
    name: str, driver: Driver, port: str, before: LinkCounts, seconds: float, now: float,
) -> DiagnosticStatus:
    """Say how well the line works; faults are counted over the last interval."""
    counts = driver.counts
    faults = counts.checksum_failures - before.checksum_failures
    faults += counts.implausible_frames - before.implausible_frames
    faults += counts.impossible_jumps - before.impossible_jumps
    garbage = counts.garbage_bytes - before.garbage_bytes
    level, message = OK, 'frames arrive'
    if driver.link is not Link.UP:
        level, message = ERROR, driver.link.value
    elif driver.frame_budget.complaint:
        level, message = WARN, driver.frame_budget.complaint
    elif faults or garbage:
        level, message = WARN, 'bytes arrive damaged'
    return status(f'{name}: serial link', level, message, {
        'port': port, 'frames per second': round((counts.frames - before.frames) / seconds, 1),
        'damaged frames': faults, 'garbage bytes': garbage,
        'seconds since a frame': round(now - driver.heard_at, 2) if counts.frames else 'never',
        'silences since start': counts.silences,
        'checksum': driver.checksum.value if driver.checksum else 'not known yet',
        'bytes spare in a slot': driver.plan.budget.spare})


def mode(name: str, driver: Driver) -> DiagnosticStatus:
    """Say whether the robot is in the wanted mode, and why not."""
    known = driver.status
    actual = 'unknown' if known.actual is None else known.actual.name
    level, message = OK, actual
    if known.actual is None:
        level, message = STALE, known.reason
    elif known.actual != known.wanted:
        level, message = WARN, f'{actual} instead of {known.wanted.name}: {known.reason}'
    return status(f'{name}: mode', level, message, {
        'mode': actual, 'wanted': known.wanted.name, 'reason': known.reason})


def safety(name: str, driver: Driver) -> DiagnosticStatus:
    """Say what touches the robot, or keeps it from driving."""
    readings = driver.readings
    if driver.link is not Link.UP or not readings.has(*TOUCHED):
        return status(f'{name}: safety', STALE, 'no robot answers', {})
    bumps = readings.bumps_and_wheel_drops & (
        oi.BumpsAndWheelDrops.BUMP_LEFT | oi.BumpsAndWheelDrops.BUMP_RIGHT)
    hazards = [cause.value for cause in driver.hazards]
    overcurrents = [bit.name or '' for bit in oi.Overcurrents if readings.overcurrents & bit]
    level, message = _safety(driver, hazards, overcurrents)
    return status(f'{name}: safety', level, message, {
        'bumper': 'pressed' if bumps else 'free', 'hazards': ', '.join(hazards) or 'none',
        'overcurrent': ', '.join(overcurrents).lower() or 'none'})


def _safety(driver: Driver, hazards: list[str], overcurrents: list[str]) -> Verdict:
    if any(wheel.endswith('WHEEL') for wheel in overcurrents):
        return ERROR, 'a wheel is blocked: free it'
    if overcurrents:
        return WARN, 'a low side driver draws too much current: switch it off'
    if hazards:
        return WARN, ', '.join(hazards)
    if driver.status.actual is oi.Mode.FULL:
        return OK, 'Full mode: the robot does not stop at cliffs by itself'
    return OK, 'nothing in the way'


def battery(name: str, driver: Driver, *, charge_known: bool) -> DiagnosticStatus:
    """Say whether the battery lasts, and whether it is charged where it could be."""
    readings = driver.readings
    if driver.link is not Link.UP or not readings.has(
            'battery_capacity', 'charging_sources', 'oi_mode'):
        return status(f'{name}: battery', STALE, 'no robot answers', {})
    state = BatteryState()
    convert.battery_state(state, readings, charge_known=charge_known)
    level, message = _battery(readings, state, driver.battery.level)
    return status(f'{name}: battery', level, message, {
        'voltage (V)': round(state.voltage, 3), 'current (A)': round(state.current, 3),
        'charge (%)': 'not known' if isnan(state.percentage) else round(100 * state.percentage),
        'temperature (C)': state.temperature,
        'charging': oi.ChargingState(readings.charging_state).name.lower()})


def _battery(readings: oi.Readings, state: BatteryState, watched: BatteryLevel) -> Verdict:
    if readings.charging_state == oi.ChargingState.FAULT:
        return ERROR, 'charging fault: check battery and charger'
    if state.temperature >= TOO_HOT:
        return ERROR, f'{state.temperature:.0f} degrees Celsius: switch it off'
    if readings.charging_state in CHARGED:
        return OK, 'on the charger'
    if readings.charging_sources and readings.oi_mode in oi.ACTUATE:
        return WARN, f'does not charge in {readings.oi_mode.name}: call set_mode with PASSIVE'
    if state.percentage < EMPTY or watched is BatteryLevel.EMPTY:
        return ERROR, 'empty: charge it now'
    if state.percentage < LOW or watched is BatteryLevel.LOW:
        return WARN, 'low: charge it soon'
    if state.temperature >= HOT:
        return WARN, f'hot: {state.temperature:.0f} degrees Celsius'
    return OK, 'charge not known' if isnan(state.percentage) else 'charged enough'


def driver(name: str, driver: Driver, stale_commands: int) -> DiagnosticStatus:
    """Say what the driver itself is at."""
    level, message = OK, 'driving' if driver.moving else 'waiting for commands'
    if driver.hearing.deaf:
        level, message = ERROR, 'the robot does not hear: switch it off and on'
    elif driver.scripts.refusal:
        level, message = WARN, driver.scripts.refusal
    elif driver.turning.stuck:
        level, message = WARN, 'told to turn, but the angle does not change: wheels blocked?'
    return status(f'{name}: driver', level, message, {
        'stale commands dropped': stale_commands,
        'songs stored': ', '.join(map(str, sorted(driver.actuators.songs))) or 'none'})


def parameters(name: str, values: Parameters) -> DiagnosticStatus:
    """Say what runs and how it is set, so that every recording tells."""
    return status(f'{name}: parameters', OK, f'version {__version__}', {
        'version': __version__, **asdict(values)})
