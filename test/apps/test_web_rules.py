"""The rules of `create_web`: who may see and drive, what a page may send, what it is told."""

import json
from math import inf, nan, pi

from create_oi_msgs.msg import Bumper, Cliff, IrOmni, Mode, Wall
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
import pytest
from sensor_msgs.msg import BatteryState

from create_oi_ros.apps.web.access import Access, BURST, host_of, is_loopback, MessageBudget, RATE
from create_oi_ros.apps.web.battery_time import BatteryTime
from create_oi_ros.apps.web.driver_seat import (
    DriverSeat,
    HOLD,
    OLDEST_VIEW,
    Refused,
    TOP_TURN,
    Velocity,
)
from create_oi_ros.apps.web.live_robot import Cursor, LiveRobot, SILENT
from create_oi_ros.apps.web.page_messages import MessageError, MESSAGES, read
from create_oi_ros.apps.web.past import MOST_OLD, NewestLog, OLD_STEP, RECENT, STEP, TrackLog
from create_oi_ros.apps.web.world_frame import FlatPose, WorldFrame
from create_oi_ros.robot import TOP_SPEED
from create_oi_ros.ros import topics
from support.anything import anything

AHEAD = Velocity(0.2, 0.0)


# Who may open the page.

@pytest.mark.parametrize('host', ['127.0.0.1', '127.0.0.2', '::1', 'localhost'])
def test_these_mean_this_computer(host):
    assert is_loopback(host)


@pytest.mark.parametrize('host', ['0.0.0.0', '192.168.1.5', '::', 'localhost.evil.example', ''])
def test_these_do_not(host):
    assert not is_loopback(host)


@pytest.mark.parametrize(('header', 'ok'), [
    ('localhost:8080', True), ('127.0.0.1:8080', True), ('[::1]:8080', True), ('LOCALHOST', True),
    ('evil.example:8080', False), ('127.0.0.1.evil.example', False), ('', False), ('[', False),
    ('localhost@evil.example', False)])
def test_without_a_token_only_names_of_this_computer_are_answered(header, ok):
    assert Access().admits_host(header) is ok
    assert Access('secret').admits_host(header)


def test_a_host_header_that_cannot_be_read_is_no_host():
    assert host_of('[::1') == ''


def test_the_token_must_be_right():
    access = Access('secret')
    assert access.admits_token('secret')
    for wrong in ('', 'secre', 'secrett', 'Secret', 'sécret', '\udcff'):
        assert not access.admits_token(wrong)
    assert Access().admits_token('')


@pytest.mark.parametrize(('origin', 'ok'), [
    ('http://robot:8080', True), ('https://robot:8080', True), ('http://robot:8081', False),
    ('http://robot', False), ('http://evil.example', False), ('null', False), ('', False),
    ('file://', False), ('http://robot:8080.evil.example', False), ('http://[', False)])
def test_only_the_page_of_this_server_may_connect(origin, ok):
    assert Access.same_origin(origin, 'robot:8080') is ok


def test_without_a_host_nothing_is_of_the_same_origin():
    assert not Access.same_origin('http://', '')


def test_a_page_may_send_so_many_messages_at_once_and_so_many_a_second():
    budget = MessageBudget(now=0.0)
    assert all(budget.spend(0.0) for _ in range(int(BURST)))
    assert not budget.spend(0.0)
    assert budget.spend(1.5 / RATE)
    assert not budget.spend(1.5 / RATE)
    late = MessageBudget(now=0.0)
    assert sum(late.spend(1e6) for _ in range(1000)) == BURST


# Who drives.

def driven(viewer=1, now=0.0) -> DriverSeat:
    """Return a seat whose viewer drives."""
    seat = DriverSeat()
    assert seat.drive(viewer, AHEAD, 0.0, now)
    return seat


def test_who_drives_first_has_the_seat_and_others_must_take_it_over():
    seat = driven(viewer=1)
    with pytest.raises(Refused, match='Take over'):
        seat.drive(2, AHEAD, 0.0, 0.0)
    with pytest.raises(Refused, match='Take over'):
        seat.sit(2)
    assert not seat.release(2) and not seat.leave(2)
    assert seat.take_over(2), 'the wheels stop'
    assert seat.viewer == 2 and not seat.driving
    with pytest.raises(Refused):
        seat.drive(1, AHEAD, 0.0, 0.0)
    assert not seat.take_over(2)


def test_a_command_holds_for_a_moment_only():
    seat = driven(now=10.0)
    assert not seat.expire(10.0 + HOLD - 0.001)
    assert seat.expire(10.0 + HOLD)
    assert not seat.driving and seat.velocity == Velocity()
    assert not seat.expire(11.0), 'once'
    assert HOLD < 0.3, 'the wheels stop within 0.3 s'


def test_letting_go_leaving_and_stop_end_it_at_once():
    for end in (lambda seat: seat.release(1), lambda seat: seat.leave(1)):
        seat = driven()
        assert end(seat) and not seat.driving
        assert not end(seat), 'no second time'
    seat = driven()
    seat.stop()
    assert not seat.driving


def test_after_stop_the_stick_must_have_been_let_go():
    seat = driven()
    seat.stop()
    assert not seat.drive(1, AHEAD, 0.0, 0.1)
    seat.release(1)
    assert seat.drive(1, AHEAD, 0.0, 0.2)


def test_stop_does_not_bind_who_sits_down_later():
    seat = DriverSeat()
    seat.stop()
    assert seat.drive(1, AHEAD, 0.0, 0.0)


@pytest.mark.parametrize('age', [OLDEST_VIEW + 0.01, 1e9, -OLDEST_VIEW - 0.01, nan, inf])
def test_a_page_with_an_old_picture_may_not_drive(age):
    seat = DriverSeat()
    assert not seat.drive(1, AHEAD, age, 0.0)
    assert not seat.driving


@given(st.lists(st.tuples(
    st.sampled_from(['drive', 'release', 'leave', 'take_over', 'stop', 'expire']),
    st.integers(1, 3), st.floats(0, 0.3))))
def test_whatever_happens_nobody_drives_longer_than_a_command_holds(steps):
    seat, now, last = DriverSeat(), 0.0, -inf
    for step, viewer, seconds in steps:
        now += seconds
        match step:
            case 'drive':
                try:
                    last = now if seat.drive(viewer, AHEAD, 0.0, now) else last
                except Refused:
                    assert seat.viewer not in (None, viewer)
            case 'stop':
                seat.stop()
            case 'expire':
                seat.expire(now)
                assert not seat.driving or now < last + HOLD
            case other:
                getattr(seat, other)(viewer)
        assert seat.driving == (seat.velocity != Velocity())
        assert not seat.driving or seat.viewer is not None


# What a page may send.

GOOD = {
    'drive': {'linear': 0.1, 'angular': -1, 'seen': 12.5},
    'release': {}, 'stop': {}, 'take_over': {}, 'leave': {}, 'dock': {}, 'reset_odometry': {},
    'mode': {'mode': 'safe'},
    'song': {'notes': [[60, 0.5], [127, 0]]},
    'leds': {'play': True, 'advance': False, 'color': 0, 'intensity': 255},
}
BAD = [
    ('drive', 'linear', value) for value in (TOP_SPEED + 0.01, nan, inf, '0', None, True, [], {},
                                             10 ** 400)
] + [('drive', 'angular', -TOP_TURN - 0.1), ('drive', 'seen', -1), ('drive', 'seen', 'now'),
     ('mode', 'mode', 'off'), ('mode', 'mode', 'SAFE'), ('mode', 'mode', 2), ('mode', 'mode', []),
     ('song', 'notes', []), ('song', 'notes', [[60, 0.5]] * 17), ('song', 'notes', [[30, 1]]),
     ('song', 'notes', [[60, 4]]), ('song', 'notes', [[60.5, 1]]), ('song', 'notes', [[60]]),
     ('song', 'notes', 'la'), ('song', 'notes', [60, 61]), ('leds', 'play', 1),
     ('leds', 'color', 256), ('leds', 'color', 1.5), ('leds', 'intensity', True)]


@pytest.mark.parametrize('type_', MESSAGES)
def test_every_message_is_read(type_):
    message = read(json.dumps({'type': type_, **GOOD[type_]}))
    assert (message.type, message.fields) == (type_, GOOD[type_])


@pytest.mark.parametrize('type_', MESSAGES)
def test_fields_are_neither_missing_nor_too_many(type_):
    with pytest.raises(MessageError, match=f'{type_}: allowed fields'):
        read(json.dumps({'type': type_, **GOOD[type_], 'more': 1}))
    for name in GOOD[type_]:
        with pytest.raises(MessageError, match=name):
            read(json.dumps({'type': type_, **{
                key: value for key, value in GOOD[type_].items() if key != name}}))


@pytest.mark.parametrize(('type_', 'name', 'value'), BAD, ids=str)
def test_a_value_out_of_range_is_refused_and_what_is_allowed_is_said(type_, name, value):
    with pytest.raises(MessageError, match=f'{type_}: {name} is not allowed; allowed: '):
        read(json.dumps({'type': type_, **GOOD[type_], name: value}))


@pytest.mark.parametrize('text', [
    '', 'hello', '{', '[' * 4000, '9' * 5000, '"\\ud800', '\x00', '{"type": 1',
    "{'type': 'stop'}"])
def test_what_is_no_json_is_refused(text):
    with pytest.raises(MessageError, match='no JSON'):
        read(text)


@pytest.mark.parametrize('text', ['1', 'null', '[]', '"stop"', '["type"]'])
def test_what_is_no_object_is_refused(text):
    with pytest.raises(MessageError, match='a JSON object'):
        read(text)


@pytest.mark.parametrize('type_', [None, 1, [], {}, '', 'Drive', '__class__', 'drive '])
def test_an_unknown_type_is_refused_with_those_that_are_known(type_):
    with pytest.raises(MessageError, match='unknown type; allowed: drive, release, stop'):
        read(json.dumps({'type': type_}))


@given(st.text() | st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(
        st.sampled_from(['type', 'linear', 'notes', 'mode']) | st.text(), inner)).map(json.dumps))
def test_no_text_does_more_than_be_refused(text):
    try:
        assert read(text).type in MESSAGES
    except MessageError as error:
        assert len(str(error)) < 300


# What a page is told.

def odom(x: float = 0.0, y: float = 0.0, speed: float = 0.0) -> Odometry:
    """Return an odometry message."""
    made = Odometry()
    made.pose.pose.position.x, made.pose.pose.position.y = x, y
    made.twist.twist.linear.x = speed
    return made


BEGIN = Cursor()


def news(robot: LiveRobot, cursor: Cursor = BEGIN, now: float = 0.0):
    """Return the news since a cursor, decoded, and the next cursor."""
    text, cursor = robot.news(cursor, now)
    return json.loads(text), cursor


def test_a_page_is_told_each_change_once():
    robot = LiveRobot()
    robot.update(odom(1.0, 2.0), 0.0)
    robot.update(Mode(mode=Mode.PASSIVE, wanted=Mode.SAFE, reason='cliff'), 0.0)
    first, cursor = news(robot)
    assert first['type'] == 'news'
    assert first['pose']['x'] == 1.0
    assert first['anew'] == [1.0, 2.0]
    assert first['mode'] == {'actual': 'PASSIVE', 'wanted': 'SAFE', 'reason': 'cliff'}
    assert news(robot, cursor, 0.5) == ({'type': 'news', 'at': 0.5}, cursor)
    robot.update(odom(1.1, 2.0), 0.2)
    second, cursor = news(robot, cursor)
    assert second.keys() == {'type', 'at', 'pose', 'track'}
    assert second['track'] == [1.1, 2.0]


def test_a_touch_is_an_event_where_it_began():
    robot = LiveRobot()
    robot.update(Bumper(left=True), 0.0)
    robot.update(Bumper(), 0.0)
    assert 'events' not in news(robot)[0], 'its place is not known'
    robot.update(odom(1.0), 0.1)
    robot.update(Bumper(left=True), 0.1)
    robot.update(Bumper(left=True, right=True), 0.2)
    robot.update(Cliff(front_left=True), 0.2)
    told, cursor = news(robot)
    assert told['events'] == [['bump', 1.0, 0.0, 'left'], ['cliff', 1.0, 0.0, 'front left']]
    assert told['bump'] == {'left': True, 'right': True}
    robot.update(Bumper(), 0.3)
    robot.update(Bumper(right=True), 0.3)
    assert news(robot, cursor)[0]['events'] == [['bump', 1.0, 0.0, 'right']]


def test_after_a_reset_of_the_odometry_the_track_begins_anew():
    robot = LiveRobot()
    robot.update(odom(3.0), 0.0)
    robot.update(Bumper(left=True), 0.0)
    _, cursor = news(robot)
    robot.update(odom(0.0), 0.02)
    told, cursor = news(robot, cursor)
    assert told['anew'] == [0.0, 0.0]
    assert 'events' not in told
    robot.forget()
    assert news(robot, cursor)[0]['anew'] == []


@pytest.mark.parametrize('place', [nan, inf, 1e9])
def test_a_place_that_cannot_be_drawn_is_left_out(place):
    robot = LiveRobot()
    robot.update(odom(place), 0.0)
    told, _ = news(robot)
    assert 'pose' not in told and told['anew'] == []


def test_a_heading_that_is_no_number_is_left_out():
    robot, message = LiveRobot(), odom()
    message.pose.pose.orientation.z = nan
    robot.update(message, 0.0)
    assert 'pose' not in news(robot)[0]


def test_samples_come_five_times_a_second_while_the_driver_speaks():
    robot = LiveRobot()
    robot.sample(0.0)
    told, cursor = news(robot)
    assert told['silent'] is True and 'samples' not in told
    for step in range(20):
        robot.update(odom(speed=0.2), step / 20)
        robot.update(Wall(signal=step), step / 20)
        robot.sample(step / 20)
    told, cursor = news(robot, cursor)
    assert told['silent'] is False
    assert len(told['samples']) == 5
    assert told['samples'][0] == [0.0, 0.2, 0.0, None, None, None, None, None, 0]
    robot.sample(1.0 + SILENT)
    assert news(robot, cursor)[0]['silent'] is True


@given(st.data())
def test_any_message_of_a_driver_becomes_json(data):
    robot = LiveRobot()
    heard = [topic.type for topic in topics.SENSOR_TOPICS if topic.name != 'cargo_bay']
    for _ in range(3):
        robot.update(data.draw(anything(data.draw(st.sampled_from([*heard, Odometry, Mode])))), 0)
    robot.sample(0.1)
    news(robot)


def test_the_name_of_an_infrared_character_is_told():
    robot = LiveRobot()
    robot.update(IrOmni(character=248, name='home_base_red_buoy'), 0.0)
    assert news(robot)[0]['infrared'] == {'code': 248, 'name': 'home_base_red_buoy'}


def test_a_log_keeps_the_newest_and_tells_each_reader_what_is_new_for_it():
    log = NewestLog(3)
    for each in 'abcde':
        log.add(each)
    assert (log.since(0), log.since(3), log.since(5)) == (['c', 'd', 'e'], ['d', 'e'], [])


def test_a_track_is_whole_for_ten_minutes_and_then_has_fewer_points():
    track, speed = TrackLog(), 0.1
    for second in range(int(2 * RECENT) + 1):
        track.add(FlatPose(speed * second, 0.0, 0.0), float(second))
    xs = track.whole()[::2]
    old = [x for x in xs if x < speed * RECENT - 1e-9]
    assert len(xs) - len(old) == RECENT + 1
    steps = [b - a for a, b in zip(old, old[1:])]
    assert min(steps) >= OLD_STEP - 1e-9
    assert track.since(track.count - 2) == xs_and_zeros(xs[-2:])


def xs_and_zeros(xs):
    """Return points on the x axis, as x, y, x, y."""
    return [value for x in xs for value in (x, 0.0)]


def test_a_robot_that_stands_adds_no_points():
    track = TrackLog()
    for second in range(100):
        track.add(FlatPose(STEP / 2 * (second % 2), 0.0, 0.0), float(second))
    assert track.whole() == [0.0, 0.0]


def test_a_track_of_days_stays_small():
    track = TrackLog()
    for second in range(60_000):
        track.add(FlatPose(0.5 * second, 0.0, 0.0), float(second))
    assert len(track.whole()) / 2 <= MOST_OLD + RECENT + 2


def battery(charge=2.0, capacity=3.0, current=-1.0) -> dict[str, float]:
    """Return the arguments of the battery's time."""
    return {'charge': charge, 'capacity': capacity, 'current': current}


def test_the_battery_s_time_is_its_charge_over_the_current():
    assert BatteryTime().left(**battery(), now=0.0) == 120
    assert BatteryTime().left(**battery(current=2.0), now=0.0) == 30
    for unknown in (battery(charge=nan), battery(capacity=nan), battery(current=0.001),
                    battery(current=-0.03), battery(current=nan)):
        assert BatteryTime().left(**unknown, now=0.0) is None


def test_the_current_is_averaged_until_the_charger_comes_or_goes():
    time = BatteryTime()
    time.left(**battery(current=-1.0), now=0.0)
    assert 110 < time.left(**battery(current=-2.0), now=1.0) < 120
    assert time.left(**battery(current=1.0), now=2.0) == 60


def test_battery_numbers_that_are_none_are_told_as_unknown():
    robot = LiveRobot()
    robot.update(BatteryState(percentage=nan, voltage=15.0, current=-0.2, charge=nan), 0.0)
    told = news(robot)[0]['battery']
    assert (told['part'], told['minutes'], told['voltage']) == (None, None, 15.0)


def test_the_room_lies_where_both_poses_are_one():
    frame = WorldFrame()
    assert frame.update(FlatPose(0, 0, 0), FlatPose(1, 2, pi / 2), 0.0)
    assert frame.origin == pytest.approx((-2, 1, -pi / 2))
    assert not frame.update(FlatPose(0.3, 0, 0), FlatPose(1, 2.2, pi / 2), 0.5)
    assert frame.origin == pytest.approx((-2, 1, -pi / 2)), 'the difference is the error'


@pytest.mark.parametrize('after', [FlatPose(0, 0, 0), FlatPose(2, 0, 3)])
def test_it_is_found_again_after_a_reset(after):
    frame = WorldFrame()
    frame.update(FlatPose(2, 0, 0), FlatPose(0, 0, 0), 0.0)
    assert frame.update(after, FlatPose(0, 0, 0), 0.1)
    assert frame.origin == pytest.approx(after)
    frame.reset()
    assert frame.update(after, FlatPose(1, 0, 0), 0.2)
