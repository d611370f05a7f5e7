# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Actions that move no wheel, from a client to the simulated robot."""

from action_msgs.msg import GoalStatus
from create_oi_msgs.action import AudioNoteSequence, DriveDistance
import pytest

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


@pytest.mark.parametrize(('fields', 'says'), [
    ({'notes': 'C4:9'}, "'C4:9' lasts 9 s; allowed: 1/64 to 255/64 s"),
    ({'notes': ''}, 'a tune needs a note, such as C4:1/4'),
    ({'notes': 'C4:1', 'iterations': 0}, 'iterations = 0; allowed: above 0, or -1'),
])
def test_a_wrong_tune_is_rejected_and_the_log_says_why(ready, client, fields, says):
    assert play(client, **fields) is None
    ready.ros.until(lambda: f'audio_note_sequence rejected: {says}' in ready.node.output, says)
    assert says in malformed('audio_note_sequence', AudioNoteSequence.Goal(**fields))
