# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The rules of `create_web`: who may open the page, who drives, and what a page may send."""

import json
from math import inf, nan

from create_oi_msgs.action import AudioNoteSequence, Dock, DriveArc, NavigateToPosition
import pytest

from create_oi_ros.apps.web.access import (
    Access,
    BURST,
    DriverSeat,
    HOLD,
    MessageBudget,
    OLDEST_VIEW,
    RATE,
    Refused,
    TOP_TURN,
)
from create_oi_ros.apps.web.page_messages import (
    CALLS,
    feedback_part,
    MessageError,
    MESSAGES,
    read,
)
from create_oi_ros.driver.goals.goal import Velocity
from create_oi_ros.robot import TOP_SPEED
from create_oi_ros.ros.driver_client import ACTION_TYPES, SERVICE_TYPES
from support.source import PACKAGE, ROOT

AHEAD = Velocity(0.2, 0.0)


# Who may open the page.

@pytest.mark.parametrize(('header', 'ok'), [
    ('localhost:8080', True), ('127.0.0.1:8080', True), ('[::1]:8080', True), ('LOCALHOST', True),
    ('evil.example:8080', False), ('127.0.0.1.evil.example', False), ('', False), ('[', False),
    ('[::1', False), ('localhost@evil.example', False)])
def test_without_a_token_only_names_of_this_computer_are_answered(header, ok):
    assert Access().admits_host(header) is ok
    assert Access('secret').admits_host(header)


def test_the_token_must_be_right():
    access = Access('secret')
    assert access.admits_token('secret')
    for wrong in ('', 'secre', 'secrett', 'Secret', 'sécret', '\udcff'):
        assert not access.admits_token(wrong)
    assert Access().admits_token('')


@pytest.mark.parametrize(('origin', 'host', 'ok'), [
    ('http://robot:8080', 'robot:8080', True), ('https://robot:8080', 'robot:8080', True),
    ('http://robot:8081', 'robot:8080', False), ('http://robot', 'robot:8080', False),
    ('http://evil.example', 'robot:8080', False), ('null', 'robot:8080', False),
    ('', 'robot:8080', False), ('file://', 'robot:8080', False),
    ('http://robot:8080.evil.example', 'robot:8080', False), ('http://[', 'robot:8080', False),
    ('http://', '', False)])
def test_only_the_page_of_this_server_may_connect(origin, host, ok):
    assert Access.same_origin(origin, host) is ok


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


def test_the_page_puts_every_text_in_as_text():
    scripts = [path.read_text('utf-8') for path in (
        ROOT / PACKAGE / 'apps' / 'web' / 'page').glob('*.js')]
    assert len(scripts) > 5
    for word in ('innerHTML', 'outerHTML', 'insertAdjacentHTML', 'document.write', 'eval('):
        assert not any(word in script for script in scripts)


# What a page may send: every message, every goal, and what is refused.


GOOD = {
    'drive': {'linear': 0.1, 'angular': -1, 'seen': 12.5},
    'release': {}, 'take_over': {}, 'leave': {},
    'cancel': {'what': 'goal'}, 'ping': {}, 'record': {'on': True},
}
GOOD_GOALS = {
    'drive_distance': {'distance': -0.5, 'max_translation_speed': 0.2},
    'rotate_angle': {'angle': 1.5, 'max_rotation_speed': 1},
    'drive_arc': {'angle': 1.5, 'radius': 0.4, 'translate_direction': -1},
    'navigate_to_position': {'goal_pose': {'pose': {'position': {'x': 1, 'y': -2.5}}}},
    'dock': {}, 'undock': {},
    'audio_note_sequence': {'notes': 'C4:1/4 60:0.5'},
}
GOOD_CALLS = {
    'set_mode': {'mode': 2}, 'stop': {}, 'reset_odometry': {},
    'set_leds': {'play': True, 'power_color': 255},
}
BAD = [
    ('drive', 'linear', value) for value in (TOP_SPEED + 0.01, nan, inf, '0', None, True, [], {},
                                             10 ** 400)
] + [('drive', 'angular', -TOP_TURN - 0.1), ('drive', 'seen', -1), ('drive', 'seen', 'now'),
     ('cancel', 'what', 'all'), ('record', 'on', 1)]
BAD_REQUESTS = [
    ('drive_distance', {'distance': 1001}, 'allowed: -1000 to 1000'),
    ('drive_distance', {'distance': nan}, 'not finite'),
    ('drive_distance', {'distance': 10 ** 400}, 'distance = 1000.* of type float'),
    ('drive_distance', {'far': 1}, "has no field 'far'; allowed: distance, max_translation_speed"),
    ('navigate_to_position', {'goal_pose': {'pose': {'position': {'x': 'far'}}}},
     "goal_pose: pose: position: x = 'far'; allowed"),
    ('audio_note_sequence', {'notes': 'la'}, 'such as C4:1/4'),
    ('set_mode', {'mode': 'safe'}, "mode = 'safe'; allowed"),
    ('stop', {'now': True}, "has no field 'now'; allowed: none"),
    ('set_leds', {'power_color': 256}, 'of type uint8'),
]
"""What may be in a field is told by the tests of `filled` and of the actions."""


@pytest.mark.parametrize('type_', MESSAGES)
def test_every_message_is_read_if_no_field_is_missing_or_too_many(type_):
    message = read(json.dumps({'type': type_, **GOOD[type_]}))
    assert (message.type, message.fields) == (type_, GOOD[type_])
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


@pytest.mark.parametrize(('texts', 'why'), [
    (('', 'hello', '{', '[' * 4000, '9' * 5000, '"\\ud800', '\x00', '{"type": 1',
      "{'type': 'stop'}"), 'no JSON'),
    (('1', 'null', '[]', '"stop"', '["type"]'), 'a JSON object'),
    (map(json.dumps, ({'type': type_} for type_ in (
        None, 1, [], {}, '', 'Drive', '__class__', 'drive '))),
     'unknown type; allowed: drive, release, take_over')])
def test_what_is_no_message_is_refused_with_what_is_allowed(texts, why):
    for text in texts:
        with pytest.raises(MessageError, match=why):
            read(text)


# Goals.

@pytest.mark.parametrize('name', ACTION_TYPES)
def test_every_action_that_the_page_shows_takes_a_goal_with_its_own_fields(name):
    goal = read(json.dumps({'type': name, **GOOD_GOALS[name]})).request
    assert isinstance(goal, ACTION_TYPES[name].Goal)


@pytest.mark.parametrize('name', CALLS)
def test_a_service_gets_a_request_with_its_own_fields(name):
    request = read(json.dumps({'type': name, **GOOD_CALLS[name]})).request
    assert isinstance(request, SERVICE_TYPES[name].Request)
    assert {field: getattr(request, field) for field in GOOD_CALLS[name]} == GOOD_CALLS[name]


def test_what_a_goal_leaves_out_has_its_default_and_what_it_has_is_taken():
    goal = read(json.dumps({'type': 'drive_distance', 'distance': 1})).request
    assert (goal.distance, goal.max_translation_speed) == (1.0, pytest.approx(0.3))
    goal = read(json.dumps(
        {'type': 'navigate_to_position', **GOOD_GOALS['navigate_to_position']})).request
    place = goal.goal_pose.pose.position
    assert (place.x, place.y, goal.achieve_goal_heading) == (1.0, -2.5, False)


@pytest.mark.parametrize(('type_', 'fields', 'why'), BAD_REQUESTS, ids=str)
def test_a_request_that_no_robot_could_follow_is_refused_by_name(type_, fields, why):
    with pytest.raises(MessageError, match=f'^{type_}.*{why}') as refused:
        read(json.dumps({'type': type_, **fields}))
    assert refused.value.to == type_


def test_feedback_becomes_json_and_leaves_out_what_is_no_number():
    made = NavigateToPosition.Feedback(
        navigate_state=2, remaining_angle_travel=nan, remaining_travel_distance=0.12345)
    assert feedback_part(made) == {'navigate_state': 2, 'remaining_travel_distance': 0.123}
    assert feedback_part(Dock.Feedback(sees_dock=True))['sees_dock'] is True
    assert feedback_part(DriveArc.Feedback()) == {'remaining_angle_travel': 0.0}
    assert feedback_part(AudioNoteSequence.Feedback(note='C4', place=2)) == {
        'note': 'C4', 'place': 2, 'iterations_played': 0}
