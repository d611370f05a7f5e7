# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Keys of `create_view`: their actions, and how long they drive."""

from math import inf, pi
from pathlib import Path

from create_oi_msgs.action import WallFollow
from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.apps.view.keys import (
    action_of,
    BINDINGS,
    CONFIRM,
    Confirmation,
    DriveKey,
    GoalCall,
    KeyDecoder,
    ServiceCall,
    SONG,
    STOP,
    ViewCommand,
)
from create_oi_ros.apps.view.teleop import FASTEST, FASTEST_TURN, HOLD, PERIOD, Teleop
from create_oi_ros.driver.goals.goal import Velocity
from create_oi_ros.ros.actions import ACTIONS
from create_oi_ros.ros.services import SERVICES

ROOT = Path(__file__).parents[2]
ACTION_TYPES = {action.name: action.type for action in ACTIONS}
TYPES = {service.name: service.type for service in SERVICES}
TYPED = (b'w', b'\x1b[A', b'\x1bOA', b'\x1b[1;5C', b'\x1b[D', b'\x1b[3~', b'\x1bOP', b' ', b'Q',
         b'\xc3\xa9', b'\x1b[24;80R')


def actions(typed: bytes) -> list[object]:
    """Return the actions of some bytes."""
    return [action for key in KeyDecoder().decode(typed) if (action := action_of(key))]


@pytest.mark.parametrize(('typed', 'action'), [
    (b'w', DriveKey(forward=1)), (b'W', DriveKey(forward=1)), (b'\x1b[A', DriveKey(forward=1)),
    (b'\x1bOA', DriveKey(forward=1)), (b'\x1b[1;2A', DriveKey(forward=1)),
    (b's', DriveKey(forward=-1)), (b'\x1b[B', DriveKey(forward=-1)),
    (b'a', DriveKey(turn=1)), (b'\x1b[D', DriveKey(turn=1)),
    (b'd', DriveKey(turn=-1)), (b'\x1b[C', DriveKey(turn=-1)),
    (b' ', ViewCommand.STOP), (b'+', ViewCommand.FASTER), (b'=', ViewCommand.FASTER),
    (b'-', ViewCommand.SLOWER),
    (b'1', ServiceCall('set_mode', {'mode': 1})), (b'2', ServiceCall('set_mode', {'mode': 2})),
    (b'3', ServiceCall('set_mode', {'mode': 3})),
    (b'i', GoalCall('drive_distance', {'distance': 0.3})),
    (b'k', GoalCall('drive_distance', {'distance': -0.3})),
    (b'j', GoalCall('rotate_angle', {'angle': pi / 2})),
    (b'l', GoalCall('rotate_angle', {'angle': -pi / 2})),
    (b'f', GoalCall('wall_follow', {'follow_side': WallFollow.Goal.FOLLOW_RIGHT})),
    (b'u', GoalCall('undock')),
    (b'g', GoalCall('dock')), (b'r', ServiceCall('reset_odometry')),
    (b'c', ViewCommand.CLEAR), (b'\x0c', ViewCommand.REDRAW),
    (b'h', ViewCommand.HELP), (b'?', ViewCommand.HELP),
    (b'q', ViewCommand.QUIT), (b'Q', ViewCommand.QUIT),
    (b'\x1a', ViewCommand.SUSPEND), (b'\x03', ViewCommand.QUIT), (b'\x04', ViewCommand.QUIT),
    (b'\x1bq', ViewCommand.QUIT), (b'\x1b\x1b[A', DriveKey(forward=1)),
])
def test_action_of_a_key(typed, action):
    assert actions(typed) == [action]


@pytest.mark.parametrize('typed', [
    b'', b'\x1b', b'\x1b[', b'\x1b[3~', b'\x1bOP', b'\x1b[24;80R', b'\x1b[1;5', b'x', b'\x00',
    b'\xc3\xa9', b'\r', b'\t'])
def test_other_keys_do_nothing(typed):
    assert actions(typed) == []


@given(st.lists(st.sampled_from(TYPED), max_size=8).map(b''.join), st.data())
def test_however_bytes_are_cut_the_keys_are_the_same(typed, data):
    cut = data.draw(st.integers(0, len(typed)))
    decoder = KeyDecoder()
    assert [*decoder.decode(typed[:cut]), *decoder.decode(typed[cut:])] == [
        *KeyDecoder().decode(typed)]


@given(st.binary(max_size=100))
def test_any_bytes_are_accepted(typed):
    actions(typed)


def test_no_key_has_two_actions():
    keys = [key for each in BINDINGS for key in each.keys]
    assert len(keys) == len(set(keys))


@pytest.mark.parametrize('ask', [
    *(each.action for each in BINDINGS if isinstance(each.action, ServiceCall)), STOP],
    ids=lambda ask: f'{ask.service}{ask.fields.get("mode", "")}')
def test_every_service_call_is_valid(ask):
    TYPES[ask.service].Request(**ask.fields)


@pytest.mark.parametrize('ask', [
    each.action for each in BINDINGS if isinstance(each.action, GoalCall)],
    ids=lambda ask: ask.name)
def test_every_goal_is_valid(ask):
    ACTION_TYPES[ask.name].Goal(**ask.fields)


def test_the_tune_leaves_the_songs_that_others_use_most():
    tune = next(each.action for each in BINDINGS if each.keys == ('p',))
    assert tune.fields['number'] == SONG == 15


def test_the_page_names_every_key_and_how_long_it_drives():
    page = (ROOT / 'docs' / 'view.md').read_text()
    letters = [next(key for key in each.keys if len(key) == 1) for each in BINDINGS]
    assert all(f'`{key}`' in page for key in letters if key > ' ')
    assert f'{HOLD} s' in page


def commands(teleop: Teleop, begin: float, end: float) -> list[Velocity]:
    """Return the commands between two times, polled as often as `wait` asks."""
    heard, now = [], begin
    while now < end:
        velocity = teleop.due(now)
        heard += [] if velocity is None else [velocity]
        now += min(teleop.wait(now), end - now) or PERIOD
    return heard


def test_nothing_is_commanded_before_a_key():
    assert commands(Teleop(), 0.0, 10.0) == []
    assert Teleop().wait(0.0) == inf


def test_a_press_drives_for_a_while_then_sends_one_zero():
    teleop = Teleop(0.2, 1.0)
    teleop.press(DriveKey(forward=1), 0.0)
    heard = commands(teleop, 0.0, 10.0)
    assert set(heard[:-1]) == {Velocity(0.2, 0.0)}
    assert HOLD / PERIOD <= len(heard[:-1]) + 1 <= HOLD / PERIOD + 2
    assert heard[-1] == Velocity(0.0, 0.0)
    assert not teleop.driving


def test_a_key_that_is_held_drives_on_without_a_gap():
    teleop, heard = Teleop(), []
    for step in range(100):
        teleop.press(DriveKey(turn=-1), 0.1 * step)
        heard += commands(teleop, 0.1 * step, 0.1 * step + 0.1)
    assert set(heard) == {Velocity(0.0, -1.0)}


def test_two_keys_together_are_a_curve_and_end_separately():
    teleop = Teleop(0.2, 1.0)
    teleop.press(DriveKey(forward=1), 0.0)
    teleop.press(DriveKey(turn=1), 0.3)
    assert teleop.due(0.3) == Velocity(0.2, 1.0)
    assert teleop.due(HOLD + 0.1) == Velocity(0.0, 1.0)
    assert teleop.due(HOLD + 0.31) == Velocity(0.0, 0.0)


def test_the_opposite_key_counts_at_once():
    teleop = Teleop(0.2, 1.0)
    teleop.press(DriveKey(forward=1), 0.0)
    assert teleop.due(0.0) == Velocity(0.2, 0.0)
    teleop.press(DriveKey(forward=-1), 0.01)
    assert teleop.due(0.01) == Velocity(-0.2, 0.0)


def test_release_sends_one_zero_at_once():
    teleop = Teleop()
    teleop.press(DriveKey(forward=1, turn=1), 0.0)
    teleop.due(0.0)
    teleop.release()
    assert teleop.wait(0.01) == 0.0
    assert commands(teleop, 0.01, 10.0) == [Velocity(0.0, 0.0)]


def test_release_without_a_key_sends_nothing():
    teleop = Teleop()
    teleop.release()
    assert commands(teleop, 0.0, 10.0) == []


def test_after_a_delay_it_does_not_drive_on():
    teleop = Teleop()
    teleop.press(DriveKey(forward=1), 0.0)
    teleop.due(0.0)
    assert commands(teleop, 100.0, 110.0) == [Velocity(0.0, 0.0)]


def test_speeds_change_within_what_the_robot_can():
    teleop = Teleop(0.2, 1.0)
    teleop.change_speed(1)
    assert teleop.speeds == Velocity(0.25, 1.25)
    teleop.change_speed(-1)
    assert teleop.speeds == Velocity(0.2, 1.0)
    for _ in range(50):
        teleop.change_speed(1)
    assert teleop.speeds == Velocity(FASTEST, FASTEST_TURN)
    for _ in range(50):
        teleop.change_speed(-1)
    assert 0.0 < teleop.speeds.linear < 0.05


KEYS = st.sampled_from([
    DriveKey(forward=1), DriveKey(forward=-1), DriveKey(turn=1), DriveKey(turn=-1),
    'stop', '+', '-'])


@given(st.lists(st.tuples(st.floats(0, 1), KEYS), max_size=30))
def test_whatever_is_typed_it_ends_with_a_zero_and_is_never_too_fast(typed):
    teleop, now, heard = Teleop(), 0.0, []
    for wait, key in typed:
        heard += commands(teleop, now, now + wait)
        now += wait
        match key:
            case DriveKey():
                teleop.press(key, now)
            case 'stop':
                teleop.release()
            case _:
                teleop.change_speed(1 if key == '+' else -1)
    heard += commands(teleop, now, now + 5)
    drives = any(isinstance(key, DriveKey) for _, key in typed)
    assert bool(heard) == drives
    assert not drives or heard[-1] == Velocity(0.0, 0.0)
    assert all(abs(each.linear) <= FASTEST and abs(each.angular) <= FASTEST_TURN
               for each in heard)
    assert not teleop.driving


DOCK = GoalCall('dock')


def test_a_key_that_moves_the_robot_by_itself_is_pressed_twice():
    asked = Confirmation()
    assert not asked.confirmed(DOCK, 0.0)
    assert asked.confirmed(DOCK, CONFIRM)
    # The pair is used up.
    assert not asked.confirmed(DOCK, CONFIRM + 0.1)


def test_the_second_press_must_come_in_time_and_without_another_key_between():
    asked = Confirmation()
    assert not asked.confirmed(DOCK, 0.0)
    assert not asked.confirmed(DOCK, CONFIRM + 0.01)
    assert asked.confirmed(DriveKey(forward=1), CONFIRM + 0.02)
    assert not asked.confirmed(DOCK, CONFIRM + 0.03)


@pytest.mark.parametrize('binding', BINDINGS, ids=lambda each: each.shown)
def test_keys_that_are_pressed_twice_show_it_on_the_help_page(binding):
    first = Confirmation().confirmed(binding.action, 0.0)
    assert first == (binding.shown.split() != [binding.keys[0]] * 2)


def test_all_services_that_start_a_motion_ask():
    moving = {'dock', 'start_demo'}
    assert moving <= set(TYPES)
    assert all(not Confirmation().confirmed(ServiceCall(name), 0.0) for name in moving)


def test_all_actions_in_which_the_robot_finds_its_way_ask():
    moving = {'dock', 'undock', 'wall_follow'}
    assert moving <= set(ACTION_TYPES)
    assert all(not Confirmation().confirmed(GoalCall(name), 0.0) for name in moving)
