# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What a page of `create_web` may send: every message, every goal, and what is refused."""

import json
from math import inf, nan, pi

from create_oi_msgs.action import Dock, DriveArc, NavigateToPosition
from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.apps.web.driver_seat import TOP_TURN
from create_oi_ros.apps.web.page_messages import (
    feedback_part,
    GOALS,
    MessageError,
    MESSAGES,
    read,
)
from create_oi_ros.robot import TOP_SPEED
from create_oi_ros.ros.actions import ACTIONS

GOOD = {
    'drive': {'linear': 0.1, 'angular': -1, 'seen': 12.5},
    'release': {}, 'stop': {}, 'take_over': {}, 'leave': {}, 'reset_odometry': {},
    'cancel': {}, 'ping': {}, 'record': {'on': True},
    'mode': {'mode': 'safe'},
    'song': {'notes': [[60, 0.5], [127, 0]]},
    'leds': {'play': True, 'advance': False, 'color': 0, 'intensity': 255},
    'drive_distance': {'distance': -0.5, 'speed': 0.2},
    'rotate_angle': {'angle': 1.5, 'turn': 1},
    'drive_arc': {'angle': 1.5, 'radius': 0.4, 'speed': 0.2, 'backward': True},
    'navigate_to_position': {'x': 1, 'y': -2.5, 'heading': 1.5, 'speed': 0.2},
    'dock': {}, 'undock': {},
    'wall_follow': {'seconds': 30},
}
BAD = [
    ('drive', 'linear', value) for value in (TOP_SPEED + 0.01, nan, inf, '0', None, True, [], {},
                                             10 ** 400)
] + [('drive', 'angular', -TOP_TURN - 0.1), ('drive', 'seen', -1), ('drive', 'seen', 'now'),
     ('mode', 'mode', 'off'), ('mode', 'mode', 'SAFE'), ('mode', 'mode', 2), ('mode', 'mode', []),
     ('song', 'notes', []), ('song', 'notes', [[60, 0.5]] * 17), ('song', 'notes', [[30, 1]]),
     ('song', 'notes', [[60, 4]]), ('song', 'notes', [[60.5, 1]]), ('song', 'notes', [[60]]),
     ('song', 'notes', 'la'), ('song', 'notes', [60, 61]), ('leds', 'play', 1),
     ('leds', 'color', 256), ('leds', 'color', 1.5), ('leds', 'intensity', True),
     ('drive_distance', 'distance', 1001), ('drive_distance', 'distance', nan),
     ('drive_distance', 'speed', 0), ('drive_distance', 'speed', TOP_SPEED + 0.01),
     ('rotate_angle', 'angle', inf), ('rotate_angle', 'turn', -1),
     ('drive_arc', 'radius', 0), ('drive_arc', 'backward', -1),
     ('navigate_to_position', 'x', None), ('navigate_to_position', 'heading', 'north'),
     ('navigate_to_position', 'heading', nan), ('wall_follow', 'seconds', 0),
     ('wall_follow', 'seconds', 1e9)]


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


# Goals.

def test_every_action_has_a_goal_and_its_request_is_of_the_action_s_type():
    assert GOALS.keys() == {action.name for action in ACTIONS}
    for action in ACTIONS:
        assert isinstance(GOALS[action.name].request(GOOD[action.name]), action.type.Goal)


def test_a_place_without_a_heading_asks_for_none():
    goal = GOALS['navigate_to_position']
    turned = goal.request({'x': 1, 'y': 2, 'heading': pi, 'speed': 0.1})
    pose = turned.goal_pose.pose
    assert (pose.position.x, pose.position.y, pose.orientation.z) == (1.0, 2.0, 1.0)
    assert turned.achieve_goal_heading
    assert goal.checks['heading'].passes(None)
    assert not goal.request({'x': 1, 'y': 2, 'heading': None, 'speed': 0.1}).achieve_goal_heading


@pytest.mark.parametrize(('backward', 'direction'), [(False, 1), (True, -1)])
def test_an_arc_has_a_direction(backward, direction):
    goal = GOALS['drive_arc'].request({**GOOD['drive_arc'], 'backward': backward})
    assert goal.translate_direction == direction


def test_feedback_becomes_json_and_leaves_out_what_is_no_number():
    made = NavigateToPosition.Feedback(
        navigate_state=2, remaining_angle_travel=nan, remaining_travel_distance=0.12345)
    assert feedback_part(made) == {'navigate_state': 2, 'remaining_travel_distance': 0.123}
    assert feedback_part(Dock.Feedback(sees_dock=True))['sees_dock'] is True
    assert feedback_part(DriveArc.Feedback()) == {'remaining_angle_travel': 0.0}
