# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals from a page of `create_web`: sent, watched, cancelled, and ended when the page goes."""

from contextlib import closing
import signal

import pytest

from support.web import ready, Relay

LONG_WAY = {'distance': 20.0, 'max_translation_speed': 0.3}


@pytest.fixture
def opened(shared, pages):
    """Return a function that opens a page of the robot, which is in SAFE."""
    return lambda through=shared.address: ready(pages(through))


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


def test_goals_are_sent_watched_and_reached(shared, opened):
    page, witness = opened(), opened()
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


def test_a_goal_that_cannot_be_reached_says_why(shared, opened):
    page = opened()
    reply = pursued(page, 'undock')
    assert not reply['ok'] and reply['text']
    reply = pursued(page, 'drive_arc', angle=900, radius=900, translate_direction=1)
    assert not reply['ok'] and 'allowed' in reply['text']
    page.send('cancel', what='goal')
    assert page.reply()['text'] == 'no goal of a page is under way'
    page.send('drive_distance', distance='far')
    assert not page.reply()['ok'] and shared.robot.standing


def test_a_goal_ends_by_cancel_stop_and_take_over(shared, opened):
    page, other = opened(), opened()
    for end in ('cancel', 'stop', 'take_over'):
        page.until(lambda: goal_of(page).get('state') not in ('sent', 'under way', 'canceling'))
        sets_out(page, shared.robot, 'drive_distance', **LONG_WAY)
        other.send(end, **({'what': 'goal'} if end == 'cancel' else {}))
        assert not page.reply()['ok']
        shared.ros.until(lambda: shared.robot.standing)
    page.send('drive_distance', **LONG_WAY)
    assert page.reply()['text'].startswith('another page drives')


def test_stop_right_behind_a_goal_stops_it(shared, opened):
    page = opened()
    page.send('drive_distance', **LONG_WAY)
    page.send('stop')
    replies = {reply['to']: reply['ok'] for reply in (page.reply(), page.reply())}
    assert replies == {'drive_distance': False, 'stop': True}
    page.until(lambda: goal_of(page).get('state') == 'canceled')
    shared.ros.until(lambda: shared.robot.standing)


def test_a_goal_ends_when_the_network_of_its_page_fails(shared, opened):
    witness = opened()
    with closing(Relay(witness.address)) as relay:
        page = opened(relay.address)
        sets_out(page, shared.robot, 'drive_distance', **LONG_WAY)
        relay.freeze()
        witness.until(lambda: goal_of(witness).get('state') in ('canceled', 'ended'))
        shared.ros.until(lambda: shared.robot.standing)


def test_a_goal_ends_when_its_page_or_the_driver_goes(shared, opened):
    page, witness = opened(), opened()
    sets_out(page, shared.robot, 'drive_distance', **LONG_WAY)
    page.close()
    witness.until(lambda: goal_of(witness).get('state') in ('canceled', 'ended'))
    shared.ros.until(lambda: shared.robot.standing)
    sets_out(witness, shared.robot, 'drive_distance', **LONG_WAY)
    shared.driver.node.send(signal.SIGTERM)  # so no test comes after this one
    assert not witness.reply()['ok']
    witness.until(lambda: goal_of(witness).get('state') in ('canceled', 'ended'))
