# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is collected of a driver's messages: the newest ones, events with begin and end, jumps."""

from math import cos, inf, nan, sin

from create_oi_msgs.msg import Bumper, Buttons, Charging, Cliff, Mode, Overcurrent, Song, WheelDrop
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
import pytest

from create_oi_ros.ros.collector import Collector, KINDS, NAMES
from support.anything import anything

NAME_OF = {topic.type: name for name, topic in NAMES.items()}


def collected(*messages: tuple[float, object], collector: Collector | None = None) -> list:
    """Give messages with their times to a collector; return what began: kind, sentence, level."""
    made = collector or Collector()
    return [(span.kind, span.sentence, span.level) for time, message in messages
            for span in made.take(NAME_OF[type(message)], time, message) or ()]


def odom(x: float = 0.0, y: float = 0.0, yaw: float = 0.0, stamp: int = 0) -> Odometry:
    made = Odometry()
    made.header.stamp.sec = stamp
    made.pose.pose.position.x, made.pose.pose.position.y = x, y
    made.pose.pose.orientation.z, made.pose.pose.orientation.w = sin(yaw / 2), cos(yaw / 2)
    return made


def diagnostics(*statuses: DiagnosticStatus, node: str = 'create') -> DiagnosticArray:
    """Return what a driver says; its line is fine."""
    line = DiagnosticStatus(name='serial link', values=[KeyValue(key='port', value='/dev/x')])
    array = DiagnosticArray(status=[line, *statuses])
    for each in array.status:
        each.name = f'{node}: {each.name}'
    return array


@pytest.mark.parametrize(('message', 'expected'), [
    (Mode(mode=Mode.SAFE, wanted=Mode.SAFE), ('mode', 'Mode SAFE', '')),
    (Mode(mode=Mode.PASSIVE, wanted=Mode.SAFE, reason='lifted'),
     ('mode', 'Mode PASSIVE (lifted)', 'warn')),
    (Bumper(left=True, right=True), ('bumper', 'Bump left and right', 'warn')),
    (Cliff(front_left=True), ('cliff', 'Cliff front left', 'warn')),
    (WheelDrop(caster=True), ('wheel drop', 'Wheel drop caster', 'warn')),
    (Overcurrent(left_wheel=True), ('overcurrent', 'Too much current left wheel', 'warn')),
    (Buttons(play=True), ('buttons', 'Button play', '')),
    (Song(number=3, playing=True), ('song', 'Plays song 3', '')),
    (Charging(state=Charging.FULL_CHARGING), ('charging', 'Charging: full charging', '')),
], ids=lambda it: type(it).__name__)
def test_what_begins_is_said_once_and_again_after_its_end(message, expected):
    made = Collector()
    assert collected((0.0, message), (0.5, message), collector=made) == [expected]
    kind, = (kind for kind, spans in made.spans.items() if len(spans))
    made.take(NAME_OF[type(message)], 2.0, Mode(reason='x') if kind == 'mode' else type(message)())
    assert (made.spans[kind].all[0].start, made.spans[kind].all[0].end) == (0.0, 2.0)
    assert collected((3.0, message), collector=made) == [expected]


def test_the_number_of_a_song_may_come_late():
    made = Collector()
    collected((1.0, Song(number=0, playing=True)), (1.1, Song(number=7, playing=True)),
              (3.0, Song(number=7)), (4.0, Song(number=7, playing=True)),
              (6.0, Song(number=8, playing=True)), collector=made)
    assert [span.text for span in made.spans['song'].all] == ['song 7', 'song 7', 'song 8']


def test_a_warning_lasts_until_its_status_is_fine_or_another():
    def battery(level: int, message: str) -> DiagnosticArray:
        return diagnostics(DiagnosticStatus(
            name='battery', level=bytes([level]), message=message))
    made = Collector()
    begun = collected(
        (0.0, battery(0, 'fine')), (1.0, battery(1, 'low')), (2.0, battery(1, 'low')),
        (3.0, battery(2, 'low')), (4.0, battery(0, 'fine')), collector=made)
    assert begun == [('battery', 'battery: low', 'warn'), ('battery', 'battery: low', 'error')]
    assert [(span.start, span.end) for span in made.warnings['battery'].all] == [(1, 3), (3, 4)]


def test_diagnostics_of_others_do_not_count():
    made = Collector('robot1')
    values = [KeyValue(key='version', value='9')]
    parameters = DiagnosticStatus(name='parameters', values=values, level=b'\x02')
    own = diagnostics(parameters, node='robot1/create')
    other = diagnostics(DiagnosticStatus(name='battery', level=b'\x02'), node='robot2/create')
    assert collected((0.0, own), (0.1, other), (0.2, DiagnosticArray()), collector=made) == []
    assert made.settings == {'version': '9'} and made.link == {'port': '/dev/x'}
    assert not any(map(len, made.warnings.values()))


@pytest.mark.parametrize(('x', 'y', 'yaw', 'seconds', 'words'), [
    (2.05, 1.0, 0.0, 0.015, ''), (2.3, 1.0, 0.0, 0.3, ''), (2.0, 1.0, 0.25, 0.015, ''),
    (2.0, 1.0, 3.0, 0.5, ''), (2.3, 1.0, 0.0, 0.1, 'Odometry jumps by 0.30 m, 0 degrees'),
    (2.0, 1.0, 3.0, 0.1, 'jumps by 0.00 m, 172 degrees'), (0.0, 0.0, 0.0, 60.0, 'begins anew'),
    (0.001, 0.0, 0.0, 0.1, 'begins anew')])
def test_a_place_that_no_robot_can_come_to_in_the_time_is_a_jump(x, y, yaw, seconds, words):
    begun = collected((5.0, odom(2.0, 1.0)), (5.0 + seconds, odom(x, y, yaw)))
    assert len(begun) == bool(words)
    assert words in ''.join(sentence for _, sentence, _ in begun)


def test_messages_that_were_held_up_do_not_jump_and_what_is_no_place_is_left_out():
    assert collected((5.0, odom(0.1, stamp=10)), (5.0, odom(0.9, stamp=12))) == []
    made = Collector()
    for wrong in (odom(nan), odom(inf), odom(1e9), odom(0.0, 0.0, nan)):
        made.take('odom', 0.0, wrong)
    assert made.pose is None
    assert collected((1.0, odom(3.0)), (1.1, odom(nan)), (1.2, odom(3.1)), collector=made) == []


def test_of_a_robot_that_runs_for_days_the_last_events_are_kept():
    made = Collector(most=3)
    for second in range(100):
        made.take('bumper', second, Bumper(left=second % 2 == 0))
        made.take('odom', second, odom(float(second % 2 * 50)))
    assert [span.start for span in made.spans['bumper'].all] == [94, 96, 98]
    assert len(made.jumps) == 3


@settings(max_examples=30)
@given(st.data())
def test_any_message_of_a_driver_is_taken(data):
    made = Collector()
    for time in range(3):
        name = data.draw(st.sampled_from(['odom', *(kind.replace(' ', '_') for kind in KINDS)]))
        made.take(name, float(time), data.draw(anything(NAMES[name].type)))
    made.finish(3.0)
