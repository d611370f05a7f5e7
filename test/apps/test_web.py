# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_web` as a browser meets it: every message, every refusal, and wheels that stop."""

from contextlib import closing
from itertools import pairwise
import json
from math import nan
import signal

import aiohttp
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
import pytest
from sensor_msgs.msg import BatteryState

from create_oi_ros.apps.web.access import BURST, DriverSeat, LONGEST_MESSAGE, MOST_VIEWERS
from create_oi_ros.apps.web.live_robot import LiveRobot, MOST_POINTS, TrackLog
from create_oi_ros.oi import LedBits, Mode
from create_oi_ros.ros.collector import FlatPose
from support.simulator import taught
from support.web import (
    get,
    IN_TIME,
    LONG,
    ready,
    refusal,
    Relay,
    served,
    stops_in_time,
)

# Driving.

def test_a_page_is_told_of_the_robot_and_drives_it(shared, pages):
    page = shared.driving(pages)
    assert page.known['seat'] == {
        'driver': page.known['you'], 'device': 'computer', 'viewers': 1, 'stopped': False}
    assert page.known['top_speed'] == 0.5
    page.drive(0.2, 0.0, lambda: page.known['pose']['x'] > 0.05 and len(page.known['track']) > 4)
    page.send('release')
    stops_in_time(shared.ros, shared.robot)
    page.until(lambda: page.known['samples'] and {
        'bump', 'cliff', 'drop', 'wall', 'battery', 'charging', 'mode'} <= page.known.keys())
    page.until(lambda: page.known.get('diagnostics', {}).get('driver', {}).get(
        'values', {}).get('cmd_vel publishers') == '/create_web')


@pytest.mark.parametrize('gone', ['closed', 'silent'])
def test_wheels_do_not_brake_gently_for_a_page_that_is_gone(shared, pages, gone):
    robot, page = shared.robot, ready(pages(shared.address))
    assert shared.driver.set('max_linear_acceleration', 0.05)
    page.drive(0.4, 0.0, lambda: robot.create.actuators.wheels.left > 60)
    last = robot.create.actuators.wheels.left
    if gone == 'closed':
        page.close()
    seen = []

    def stands() -> bool:
        seen.append(robot.create.actuators.wheels.left)
        return robot.standing
    shared.ros.until(stands, within=IN_TIME)
    falls = [after for before, after in pairwise([last, *seen]) if after < before]
    assert set(falls) == {0}


def test_the_wheels_stop_when_the_network_fails_and_old_commands_move_nothing(shared, pages):
    robot, address = shared.robot, shared.address
    with closing(Relay(address)) as relay:
        page = ready(pages(relay.address))
        page.drive(0.2, 0.0, lambda: not robot.standing)
        relay.freeze()
        stops_in_time(shared.ros, robot)
        heard = shared.ros.listen(Twist, 'cmd_vel', 100)
        seen = page.known['at']
        witness = pages(address)
        witness.until(lambda: witness.known['at'] > seen + 0.6)
        for _ in range(20):  # they wait in the network, and then arrive all at once
            page.send('drive', linear=0.2, angular=0.0, seen=seen)
        page.send('set_mode', mode=2)
        relay.thaw()
        assert page.reply()['to'] == 'set_mode', 'all have arrived'
        assert robot.standing and not heard


@pytest.mark.parametrize(('end', 'timeout'), [(signal.SIGTERM, LONG), (signal.SIGKILL, 0.5)])
def test_the_wheels_stop_when_the_server_ends_or_is_killed(shared, pages, end, timeout):
    assert shared.driver.set('cmd_vel_timeout', timeout)
    web, address = served(shared.driver.stage)
    page = ready(pages(address))
    page.drive(0.2, 0.0, lambda: not shared.robot.standing)
    web.send(end)
    if end is signal.SIGTERM:
        assert web.ended() == 0
        # A command that was on its way may break the connection before the page has read why.
        assert page.closed() in (
            aiohttp.WSCloseCode.GOING_AWAY, aiohttp.WSCloseCode.ABNORMAL_CLOSURE)
    stops_in_time(shared.ros, shared.robot)
    assert 'Traceback' not in web.output


def test_one_page_drives_and_others_watch_until_they_take_over(shared, pages):
    robot, page = shared.robot, shared.driving(pages)
    other = ready(pages(page.address))
    other.send('drive', linear=0.1, angular=0.0, seen=other.known['at'])
    assert other.reply() == {
        'type': 'reply', 'to': 'drive', 'ok': False,
        'text': 'another page drives: press "Take over" first'}
    other.send('dock')
    assert not other.reply()['ok']
    other.send('take_over')
    stops_in_time(shared.ros, robot)
    other.until(lambda: other.known['seat'] == {
        'driver': other.known['you'], 'device': 'computer', 'viewers': 2, 'stopped': False})
    other.drive(-0.1, 0.0, lambda: not robot.standing)
    page.send('drive', linear=0.1, angular=0.0, seen=page.known['at'])
    assert not page.reply()['ok']
    other.send('leave')
    stops_in_time(shared.ros, robot)
    page.until(lambda: page.known['seat']['driver'] is None)


@pytest.mark.parametrize('end', [
    lambda seat: seat.release(1), lambda seat: seat.leave(1), lambda seat: seat.take_over(2)])
def test_letting_go_leaving_and_taking_over_stop_the_wheels_at_once_and_once(end):
    seat = DriverSeat()
    assert seat.drive(1, 0.0)
    assert end(seat) and not seat.driving
    assert not end(seat)


def test_stop_stops_whoever_presses_it_and_the_stick_must_be_let_go(shared, pages):
    robot, page = shared.robot, shared.driving(pages)
    other = ready(pages(page.address))
    other.send('stop')
    reply = other.reply()
    assert (reply['to'], reply['ok']) == ('stop', True)
    heard = shared.ros.listen(Twist, 'cmd_vel', 100)
    for _ in range(5):
        page.send('drive', linear=0.2, angular=0.0, seen=page.known['at'])
        page.read()
    page.send('set_mode', mode=2)
    page.reply()
    assert robot.standing and not any(each.linear.x for each in heard)
    page.send('release')
    page.drive(0.2, 0.0, lambda: not robot.standing)


def test_who_only_listens_to_commands_is_no_driver_and_does_not_choose_their_type(stage, pages):
    recorded = stage.listener('recorder').listen(Twist, 'cmd_vel')
    page = pages(served(stage)[1])
    page.until(lambda: page.known.get('driver_found') is False and page.known['silent'])
    page.send('drive', linear=0.2, angular=0.0, seen=page.known['at'])
    assert page.reply()['text'].startswith('no driver takes /cmd_vel')
    robot = stage.robot()
    stage.node(robot.link, cmd_vel_type='stamped')
    ready(page).drive(0.2, 0.0, lambda: not robot.standing)
    assert not recorded


def test_a_page_that_comes_again_takes_the_place_of_its_dead_connection(shared, pages):
    robot, address = shared.robot, shared.address
    page = ready(pages(address, name='phone-1'))
    page.drive(0.2, 0.0, lambda: not robot.standing)
    again = pages(address, name='phone-1')
    stops_in_time(shared.ros, robot)
    again.until(lambda: again.known['seat']['viewers'] == 1)
    again.drive(0.2, 0.0, lambda: not robot.standing)
    again.send('ping')
    assert again.reply() == {'type': 'reply', 'to': 'ping', 'ok': True, 'text': ''}


# Doing.

def test_leds_are_set_and_the_odometry_is_reset(shared, pages):
    robot, page = shared.robot, ready(pages(shared.address))

    def done(type_, **fields):
        page.send(type_, **fields)
        reply = page.reply()
        assert (reply['to'], reply['ok']) == (type_, True), reply
    done('set_leds', play=True, power_color=200, power_intensity=100)
    lights = robot.create.lights
    shared.ros.until(lambda: (lights.bits, lights.color, lights.intensity) == (
        LedBits.PLAY, 200, 100))
    page.drive(0.05, 0.0, lambda: len(page.known['track']) > 2)  # too little to be seen as a jump
    page.send('release')
    page.until(lambda: page.known['pose']['speed'] == 0)
    assert page.known['pose']['x'] < 0.1
    done('reset_odometry')
    page.until(lambda: page.known['track'] == [0.0, 0.0])


def test_bad_messages_are_answered_and_nothing_moves(shared, pages):
    robot, address = shared.robot, shared.address
    page = ready(pages(address))
    for text in ('{', '[' * 4000, '{"type": "fly"}', '{"type": "set_mode", "mode": "off"}',
                 '{"type": "drive", "linear": NaN, "angular": 0, "seen": 0}',
                 '{"type": "drive", "linear": 0.51, "angular": 0, "seen": 0}',
                 '{"type": "drive", "linear": 0.1, "angular": 0}',
                 '{"type": "cancel", "what": "all"}', '{"type": "release", "more": 1}',
                 '{"type": "dock", "far": 1}', '{"type": "set_leds", "power_color": 256}'):
        page.send_text(text)
        reply = page.reply()
        assert not reply['ok'] and 'allowed' in reply['text'] or 'no JSON' in reply['text']
    page.send_bytes(b'\x00\xff')
    assert page.reply()['text'] == 'allowed is text: a JSON object'
    assert robot.standing and robot.create.mode is Mode.SAFE


def test_a_page_that_sends_too_long_or_too_many_messages_is_disconnected(shared, pages):
    page = pages(shared.address)
    page.send_text('x' * (LONGEST_MESSAGE + 1))
    assert page.closed() == aiohttp.WSCloseCode.MESSAGE_TOO_BIG
    page = pages(shared.address)
    with pytest.raises((AssertionError, ConnectionError)):
        for _ in range(20 * int(BURST)):
            page.send('release')
        page.until(lambda: False)
    assert page.close_code in (None, aiohttp.WSCloseCode.POLICY_VIOLATION)


def test_one_page_too_many_is_told_so(shared, pages):
    address = shared.address
    opened = [pages(address) for _ in range(MOST_VIEWERS)]
    opened[0].until(lambda: opened[0].known.get('seat', {}).get('viewers') == MOST_VIEWERS)
    assert pages(address).closed() == aiohttp.WSCloseCode.TRY_AGAIN_LATER
    opened[0].close()
    opened[1].until(lambda: opened[1].known['seat']['viewers'] == MOST_VIEWERS - 1)
    assert pages(address).close_code is None


# What a page is told of a long drive.

def test_a_track_of_days_stays_small_and_goes_all_the_way():
    track = TrackLog()
    for second in range(60_000):
        track.add(FlatPose(0.5 * second, 0.0, 0.0))
    xs = track.since(0)[::2]
    assert len(xs) <= MOST_POINTS and (xs[0], xs[-1]) == (0.0, 0.5 * 59_999)
    assert max(b - a for a, b in zip(xs, xs[1:])) <= 8.0
    assert track.since(len(track) - 1) == [xs[-1], 0.0]


def test_a_warning_about_the_odometry_leaves_the_track_and_another_place_begins_it_anew():
    robot, elsewhere = LiveRobot(), Odometry()
    elsewhere.pose.pose.position.x = 5.0
    robot.update('odom', Odometry(), 0.0)
    robot.update('diagnostics', DiagnosticArray(status=[
        DiagnosticStatus(name='create: serial link'),
        DiagnosticStatus(name='create: odometry', level=b'\x01', message='wheels slip')]), 0.1)
    assert len(robot.log.since(0)) == 1, 'it is told'
    assert (len(robot.track), robot.resets) == (1, 0)
    robot.update('odom', elsewhere, 0.2)
    assert (len(robot.track), robot.resets) == (1, 1)
    assert robot.track.since(0) == [5.0, 0.0]


def test_the_time_of_the_battery_is_its_charge_over_the_mean_current():
    def left(current: float, now: float = 0.0, charge: float = 2.0) -> float | None:
        robot.update('battery_state', BatteryState(
            charge=charge, capacity=3.0, current=current), now)
        return json.loads(robot.parts.since(0)['battery'])['minutes']
    robot = LiveRobot()
    assert left(-1.0) == 120 and 110 < left(-2.0, 1.0) < 120
    assert left(1.0, 2.0) == 60, 'the charger has come'
    for unknown in ({'current': -0.03}, {'current': nan}, {'current': -1.0, 'charge': nan}):
        robot = LiveRobot()
        assert left(**unknown) is None


# Who may come in.

def test_only_this_computer_and_this_page_come_in(shared, pages):
    address = shared.address
    base = address.rstrip('/')
    for origin in ('http://evil.example', 'null', f'{base}.evil.example', f'{base[:-1]}'):
        assert refusal(pages, address, origin=origin) == 403, origin
    assert get(address, '/')[0] == get(address, '/', Host='localhost')[0] == 200
    for host in ('evil.example', '127.0.0.1.evil.example', 'localhost@evil.example'):
        assert get(address, '/', Host=host)[0] == 403, host
    assert get(address, '/live')[0] == 403
    for path in ('/../setup.py', '/%2e%2e/index.html', '/page/index.html', '/index.html/',
                 '/nothing.js', '//', '/__init__.py'):
        assert get(address, path)[0] == 404, path
    status, headers, body = get(address, '/main.js')
    assert (status, headers['Content-Type']) == (200, 'text/javascript; charset=utf-8')
    assert "default-src 'none'" in headers['Content-Security-Policy']
    assert headers['X-Content-Type-Options'] == 'nosniff'


# The simulated room.

def test_a_simulated_robot_shows_its_room_and_where_it_really_is(stage, pages, tmp_path):
    with taught(tmp_path, '--world', 'apartment') as (port, teacher):
        stage.node(port)
        page = ready(pages(served(stage, '--control', str(tmp_path / 'control'))[1]))
        page.until(lambda: page.known.get('true_pose') and page.known.get('room_origin'))
        assert page.known['room']['home_bases'] == [[1.0, 0.05, 1.5708]]
        assert page.known['true_pose'] == [1.0, 1.0, 1.5708]
        assert page.known['room_origin'] == pytest.approx([-1.0, 1.0, -1.5708], abs=1e-3)
        teacher.tell('bump left 0.3')
        page.until(lambda: page.known['events'])
        assert page.known['events'][0][0] == 'bumper'
        teacher.tell('quit')
        page.until(lambda: page.known['true_pose'] is None)


# Goals from a page: sent, watched, cancelled, and ended when the page goes.


LONG_WAY = {'distance': 20.0, 'max_translation_speed': 0.3}


def goal_of(page) -> dict[str, object]:
    """Return what a page knows of the newest goal."""
    return dict(page.known.get('goal') or {})


def pursued(page, name, **fields):
    """Send a goal and wait until it has ended; return the reply."""
    page.send(name, **fields)
    reply = page.reply()
    assert reply['to'] == name
    return reply


def sets_out(page, robot, name, **fields):
    """Send a goal, and wait until the robot moves."""
    page.send(name, **fields)
    page.until(lambda: not robot.standing or page.replies)
    assert not page.replies, 'it is under way'


def test_goals_are_sent_watched_and_reached(shared, pages):
    page, witness = (ready(pages(shared.address)) for _ in range(2))
    sets_out(page, shared.robot, 'drive_distance', distance=0.15)
    way = witness.until(
        lambda: (goal_of(witness).get('feedback') or {}).get('remaining_travel_distance'))
    assert 0 < way <= 0.15
    while not page.replies:  # in turns: a page that answers no ping is closed
        page.read()
        witness.read()
    reply = page.reply()
    assert reply['ok'], reply
    witness.until(lambda: goal_of(witness).get('state') == 'reached')
    assert goal_of(witness) == {
        'name': 'drive_distance', 'viewer': page.known['you'], 'state': 'reached',
        'text': reply['text'], 'feedback': None}
    assert 0.1 < shared.robot.body.truth().pose.x < 0.25
    x, y = page.known['pose']['x'], page.known['pose']['y']
    place = {'pose': {'position': {'x': x + 0.05, 'y': y}}}
    reply = pursued(page, 'navigate_to_position', goal_pose=place)
    assert reply['ok'], reply
    page.send('dock')
    page.until(lambda: page.replies or (
        goal_of(page).get('feedback') or {}).get('sees_dock') is False)
    assert not page.replies, page.replies
    page.send('cancel', what='goal')
    assert not page.reply()['ok']


def test_a_goal_that_cannot_be_reached_says_why(shared, pages):
    page = ready(pages(shared.address))
    reply = pursued(page, 'undock')
    assert not reply['ok'] and reply['text']
    reply = pursued(page, 'drive_arc', angle=900, radius=900, translate_direction=1)
    assert not reply['ok'] and 'allowed' in reply['text']
    page.send('cancel', what='goal')
    assert page.reply()['text'] == 'no goal of a page is under way'
    page.send('drive_distance', distance='far')
    assert not page.reply()['ok'] and shared.robot.standing


def test_a_goal_ends_by_cancel_stop_and_take_over(shared, pages):
    page, other = (ready(pages(shared.address)) for _ in range(2))
    for end in ('cancel', 'stop', 'take_over'):
        page.until(lambda: goal_of(page).get('state') not in ('sent', 'under way', 'canceling'))
        sets_out(page, shared.robot, 'drive_distance', **LONG_WAY)
        other.send(end, **({'what': 'goal'} if end == 'cancel' else {}))
        assert not page.reply()['ok']
        shared.ros.until(lambda: shared.robot.standing)
    page.send('drive_distance', **LONG_WAY)
    assert page.reply()['text'].startswith('another page drives')


def test_stop_right_behind_a_goal_stops_it(shared, pages):
    page = ready(pages(shared.address))
    page.send('drive_distance', **LONG_WAY)
    page.send('stop')
    replies = {reply['to']: reply['ok'] for reply in (page.reply(), page.reply())}
    assert replies == {'drive_distance': False, 'stop': True}
    page.until(lambda: goal_of(page).get('state') == 'canceled')
    shared.ros.until(lambda: shared.robot.standing)


def test_a_goal_ends_when_the_network_of_its_page_fails(shared, pages):
    witness = ready(pages(shared.address))
    with closing(Relay(witness.address)) as relay:
        page = ready(pages(relay.address))
        sets_out(page, shared.robot, 'drive_distance', **LONG_WAY)
        relay.freeze()
        witness.until(lambda: goal_of(witness).get('state') in ('canceled', 'ended'))
        shared.ros.until(lambda: shared.robot.standing)


def test_a_goal_ends_when_its_page_or_the_driver_goes(shared, pages):
    page, witness = (ready(pages(shared.address)) for _ in range(2))
    sets_out(page, shared.robot, 'drive_distance', **LONG_WAY)
    page.close()
    witness.until(lambda: goal_of(witness).get('state') in ('canceled', 'ended'))
    shared.ros.until(lambda: shared.robot.standing)
    sets_out(witness, shared.robot, 'drive_distance', **LONG_WAY)
    shared.driver.node.send(signal.SIGTERM)  # so no test comes after this one
    assert not witness.reply()['ok']
    witness.until(lambda: goal_of(witness).get('state') in ('canceled', 'ended'))
