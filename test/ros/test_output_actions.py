# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Actions that move no wheel, from a client to the simulated robot."""

from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from create_oi_msgs.action import AudioNoteSequence, DriveDistance, LedAnimation
from create_oi_msgs.srv import SetLeds
import pytest

from create_oi_ros import oi
from create_oi_ros.ros.actions import malformed
from support.actions import Client

RING_TONE = f'scale:d=16,o=5,b=180:{",".join(4 * "c c# d d# e f f# g g# a a#".split())}'
"""44 notes."""


@pytest.fixture
def client(ready):
    """Return a client of the shared robot's actions."""
    made = Client(ready.ros)
    yield made
    made.close()


def play(client, notes, **fields):
    """Ask for a tune."""
    return client.send(AudioNoteSequence, 'audio_note_sequence', notes=notes, **fields)


def test_a_long_tune_is_played_while_the_robot_drives(ready, client):
    tune = play(client, RING_TONE)
    drive = client.send(DriveDistance, 'drive_distance', distance=0.1)
    assert drive.result().success
    assert tune.result().success, tune.result().message
    assert tune.status == GoalStatus.STATUS_SUCCEEDED
    result, told = tune.result(), tune.feedback
    assert (result.iterations_played, result.message) == (1, 'the tune was played')
    assert [each.place for each in told] == sorted({each.place for each in told})
    assert (told[0].note, told[0].place) == ('C5', 0) and told[-1].place == 43
    seconds = result.runtime.sec + result.runtime.nanosec / 1e9
    assert 44 / 12 - 0.1 < seconds < 44 / 12 + 2


def test_a_tune_is_canceled(ready, client):
    tune = play(client, '60:1/8 rest:1/8', iterations=AudioNoteSequence.Goal.INFINITE)
    ready.ros.until(lambda: tune.feedback and tune.feedback[-1].iterations_played > 1, 'rounds')
    assert {each.note for each in tune.feedback} == {'C4', 'rest'}
    assert 'a tune plays: cancel its goal' in play(client, 'C4:1').result().message
    assert tune.cancel()
    assert 'canceled; the song that plays goes on' in tune.result().message
    assert tune.status == GoalStatus.STATUS_CANCELED


def animate(client, **fields):
    """Ask for an animation of the LEDs."""
    return client.send(LedAnimation, 'led_animation', **fields)


def test_leds_blink_while_the_robot_drives_and_are_then_as_before(ready, client):
    ready.ask(SetLeds, 'set_leds', advance=True)
    lights = animate(client, animation_type=LedAnimation.Goal.BLINK_LIGHTS, play=True,
                     power_color=255, power_intensity=9, period=Duration(nanosec=300_000_000),
                     max_runtime=Duration(sec=2))
    robot = ready.robot.create
    ready.ros.until(lambda: robot.lights == (oi.LedBits.PLAY, 255, 9), 'lights')
    assert client.result(DriveDistance, 'drive_distance', distance=0.1).success
    result = lights.result()
    assert (result.success, result.message) == (True, 'the animation was shown')
    assert lights.status == GoalStatus.STATUS_SUCCEEDED and result.runtime == Duration(sec=2)
    left = [each.remaining_runtime.sec + each.remaining_runtime.nanosec / 1e9
            for each in lights.feedback]
    assert left == sorted(left, reverse=True) and 1.5 < left[0] < 2 and left[-1] < 0.5
    ready.ros.until(lambda: robot.lights == (oi.LedBits.ADVANCE, 0, 0), 'the own setting')


def test_an_animation_is_canceled(ready, client):
    lights = animate(client, animation_type=LedAnimation.Goal.SPIN_LIGHTS, play=True, advance=True)
    ready.ros.until(lambda: lights.feedback, 'feedback')
    assert 'the LEDs are animated' in animate(
        client, animation_type=LedAnimation.Goal.BLINK_LIGHTS, play=True).result().message
    assert lights.cancel()
    assert lights.result().message == 'canceled'
    assert lights.status == GoalStatus.STATUS_CANCELED


TUNE, LEDS = (AudioNoteSequence, 'audio_note_sequence'), (LedAnimation, 'led_animation')


@pytest.mark.parametrize(('action', 'fields', 'says'), [
    (TUNE, {'notes': 'C4:9'}, "'C4:9' lasts 9 s; allowed: 1/64 to 255/64 s"),
    (TUNE, {'notes': ''}, 'a tune needs a note, such as C4:1/4'),
    (TUNE, {'notes': 'C4:1', 'iterations': 0}, 'iterations = 0; allowed: above 0, or -1'),
    (LEDS, {'animation_type': 3, 'play': True},
     'animation_type = 3; allowed: 1 (blink), 2 (spin)'),
    (LEDS, {'animation_type': 1, 'power_color': 9},
     'no LED is chosen: set play, advance or power_int'),
    (LEDS, {'animation_type': 1, 'play': True, 'period': Duration(nanosec=200_000_000)},
     'period = 0.2 s; allowed: 0.3 or more'),
    (LEDS, {'animation_type': 1, 'play': True, 'max_runtime': Duration(sec=-1)},
     'max_runtime = -1 s; allowed: 0 or more'),
])
def test_a_wrong_goal_is_rejected_and_the_log_says_why(ready, client, action, fields, says):
    type_, name = action
    assert client.send(type_, name, **fields) is None
    ready.ros.until(lambda: f'{name} rejected: {says}' in ready.node.output, says)
    assert says in malformed(name, type_.Goal(**fields))
