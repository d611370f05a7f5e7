# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Diagnostics of the driver with a simulated robot in memory: levels and messages."""

from copy import copy
from dataclasses import replace
from math import isnan
from typing import Any

from create_oi_msgs import msg
from create_oi_msgs.msg import Mode
from diagnostic_msgs.msg import DiagnosticStatus
import pytest
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

from create_oi_ros import oi
from create_oi_ros.driver import LinkCounts
from create_oi_ros.odometry import GyroState
from create_oi_ros.ros import diagnostics, messages
from create_oi_ros.ros.topics import SENSOR_TOPICS
from support.loop import Loop

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@pytest.fixture
def loop() -> Loop:
    """Return a loop in which the driver is connected to the robot."""
    met = Loop()
    met.run(0.3)
    return met


def all_of(loop: Loop, before: LinkCounts | None = None) -> dict[str, DiagnosticStatus]:
    """Return the statuses that the node would publish, by their names."""
    health = loop.driver.health(loop.now)
    made = [
        diagnostics.serial_link(health, 'port', before or LinkCounts()),
        diagnostics.mode(health), diagnostics.safety(health),
        diagnostics.battery(health, charge_known=True),
        diagnostics.driver(health, 0, ())]
    return {status.name: status for status in made}


def levels(loop: Loop) -> dict[str, bytes]:
    """Return the levels, by the last word of the status name."""
    return {name: status.level for name, status in all_of(loop, copy(loop.driver.counts)).items()}


def test_without_a_robot_the_link_is_the_error_and_stale_is_left_to_aggregators(loop):
    loop.cut = True
    loop.run(2.0)
    assert levels(loop) == {'serial link': ERROR, 'mode': WARN, 'safety': WARN,
                            'battery': WARN, 'driver': OK}
    before = levels(Loop())  # the first frame
    assert (before['serial link'], before['battery']) == (ERROR, WARN)


def test_a_mode_that_is_being_entered_is_no_warning(loop):
    loop.driver.modes.set(oi.Mode.FULL, loop.now)
    status = all_of(loop)['mode']
    assert (status.level, status.message) == (OK, 'SAFE, entering FULL')


def test_line_errors_are_reported_for_one_interval(loop):
    before = copy(loop.driver.counts)
    loop.driver.receive(b'nonsense' * 20, loop.now)
    loop.run(0.1)
    link = all_of(loop, before)['serial link']
    assert link.level == WARN
    assert int({each.key: each.value for each in link.values}['garbage bytes']) >= 160
    assert levels(loop)['serial link'] == OK


def on_dock(loop: Loop, charge: int, current: int = -250) -> None:
    """Let the robot stand on a dock whose charger waits."""
    loop.body.force(home_base=1, charging_state=4, capacity=2700, charge=charge, current=current)


@pytest.mark.parametrize(('charge', 'current', 'status'), [
    (80, -250, 'NOT_CHARGING'), (2600, -250, 'FULL'), (80, 900, 'CHARGING')])
def test_the_battery_state_of_a_docked_robot_is_told_by_its_current(
        loop, charge, current, status):
    on_dock(loop, charge, current)
    loop.run(1.5)
    battery = BatteryState()
    messages.battery_state(battery, loop.driver.health(loop.now).readings)
    assert battery.power_supply_status == getattr(BatteryState, f'POWER_SUPPLY_STATUS_{status}')
    assert battery.percentage == pytest.approx(charge / 2700)


@pytest.mark.parametrize(('happen', 'name', 'level', 'says'), [
    (lambda loop: loop.body.drop(left=True), 'safety', WARN, 'left wheel dropped'),
    (lambda loop: loop.body.force(cliff_right=1), 'safety', WARN, 'cliff right'),
    (lambda loop: loop.body.force(overcurrent_left_wheel=1), 'safety', ERROR, 'blocked'),
    (lambda loop: loop.body.force(overcurrent_ld1=1), 'safety', WARN, 'low side driver'),
    (lambda loop: loop.body.force(bump_left=1), 'safety', OK, ''),
    (lambda loop: None, 'mode', OK, 'SAFE'),
    (lambda loop: loop.body.drop(left=True), 'mode', WARN, 'PASSIVE instead of SAFE'),
    (lambda loop: loop.body.plug_charger(True), 'battery', OK, 'on the charger'),
    (lambda loop: loop.body.force(charging_state=5), 'battery', ERROR, 'fault'),
    (lambda loop: loop.body.force(charge=300, capacity=2700), 'battery', WARN, 'low'),
    (lambda loop: loop.body.force(charge=100, capacity=2700), 'battery', ERROR, 'empty'),
    (lambda loop: loop.body.force(charge=0, capacity=0), 'battery', OK, 'not known'),
    (lambda loop: on_dock(loop, charge=80), 'battery', ERROR,
     'empty: charge it now; it does not charge in SAFE: call set_mode with PASSIVE'),
    (lambda loop: on_dock(loop, charge=400), 'battery', WARN, 'low: charge it soon; it does not'),
    (lambda loop: on_dock(loop, charge=1500), 'battery', WARN, 'it does not charge in SAFE'),
    (lambda loop: on_dock(loop, charge=2600), 'battery', OK, 'on the charger; it is full'),
    (lambda loop: on_dock(loop, charge=80, current=900), 'battery', OK, 'it charges'),
    (lambda loop: loop.body.force(temperature=50), 'battery', WARN, 'hot'),
    (lambda loop: loop.body.force(temperature=65), 'battery', ERROR, 'switch it off'),
    (lambda loop: loop.robot.receive(oi.WaitEvent(event=oi.Event.PLAY_BUTTON).encode(), loop.now),
     'driver', ERROR, 'off and on'),
])
def test_what_happens_has_its_level(loop, happen, name, level, says):
    happen(loop)
    loop.run(4.0)
    status = all_of(loop)[name]
    assert (status.level, says in status.message) == (level, True), status.message


@pytest.mark.parametrize(('forged', 'says', 'unknown'), [
    ({'battery_charge': 63188, 'battery_capacity': 2600}, 'battery charge = 63188', 'charge'),
    ({'battery_charge': 3121, 'battery_capacity': 2600}, 'battery charge = 3121', 'charge'),
    ({'battery_charge': 65535, 'battery_capacity': 65535}, 'capacity = 65535', 'capacity'),
    ({'battery_charge': 2600, 'battery_capacity': 10001}, 'capacity = 10001', 'percentage'),
    ({'voltage': 65535}, 'voltage = 65535', 'voltage'),
    ({'current': -32768}, 'current = -32768', 'current'),
    ({'battery_temperature': -128}, 'temperature = -128', 'temperature'),
])
def test_what_no_battery_has_is_not_known_and_a_warning(loop, forged, says, unknown):
    loop.forged = forged
    loop.drive(0.1, 0.0, 1.0)
    status = all_of(loop)['battery']
    assert status.level == WARN and says in status.message
    assert 'not known' in [each.value for each in status.values]
    assert levels(loop)['serial link'] == OK
    readings = loop.driver.health(loop.now).readings
    battery = BatteryState()
    messages.battery_state(battery, readings)
    assert isnan(getattr(battery, unknown))


def filled(readings: oi.Readings, *types: type) -> list[Any]:
    """Return the messages of these types that are made of readings."""
    made = [(type_(), topic) for type_ in types for topic in SENSOR_TOPICS if topic.type is type_]
    for message, topic in made:
        topic.fill(message, readings)
    return [message for message, _ in made]


def test_values_that_no_create_has_are_counted_and_go_out_as_not_known(loop):
    loop.forged = {'oi_mode': 4, 'charging_state': 6, 'song_number': 16, 'analog_signal': 1024,
                   'cliff_left_signal': 5000, 'buttons': 3}
    loop.run(5.0)
    before = copy(loop.driver.counts)
    loop.drive(0.1, 0.0, 1.0)
    told = all_of(loop, before)
    link = {each.key: each.value for each in told['serial link'].values}
    assert told['serial link'].level == OK and int(link['odd values']) > 100
    assert 'oi mode = 4' in link['odd packets'] and 'buttons = 3' in link['odd packets']
    assert told['mode'].level == WARN and 'a mode that the manual does not have' in (
        told['mode'].message)
    health = loop.driver.health(loop.now)
    mode = messages.mode(health.mode, Header())
    assert mode.mode == Mode.UNKNOWN and messages.mode_name(mode.mode, mode.reason) == 'UNKNOWN'
    readings = health.readings
    cliff, song, bay, buttons = filled(readings, msg.Cliff, msg.Song, msg.CargoBay, msg.Buttons)
    assert (cliff.left_signal, cliff.front_left_signal) == (
        msg.Cliff.SIGNAL_UNKNOWN, readings.cliff_front_left_signal)
    assert song == msg.Song(number=msg.Song.UNKNOWN)
    assert isnan(bay.analog)
    assert buttons == msg.Buttons(play=True)
    loop.forged = {'charging_state': 6}
    loop.run(0.2)
    loop.drive(0.1, 0.0, 1.0)
    charging, = filled(loop.driver.health(loop.now).readings, msg.Charging)
    assert charging.state == charging.UNKNOWN
    assert messages.charging_name(charging.state) == 'not known'
    assert all_of(loop)['battery'].level == WARN


GOOD = GyroState(True, None, 3, False)


@pytest.mark.parametrize(('gyro', 'level', 'says', 'values'), [
    (None, OK, 'learn', {}), (GOOD, OK, 'learn', {'gyro': 'used', 'slips': '3'}),
    (GyroState(False, 'it jumps', 0, False), WARN, 'the gyro is not used: it jumps',
     {'gyro': 'it jumps', 'slips': '0'}),
    (GOOD._replace(slips_now=True), WARN, 'wheels slip', {'gyro': 'used', 'slips': '3'})])
def test_what_is_thought_of_a_gyro_is_said(loop, gyro, level, says, values):
    status = diagnostics.odometry(replace(loop.driver.health(loop.now), gyro=gyro))
    assert status.level == level and says in status.message
    assert values == {each.key: each.value for each in status.values
                      if each.key in ('gyro', 'slips')}
