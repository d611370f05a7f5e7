"""What the driver does when something is wrong with line or robot, in memory."""

from collections.abc import Callable
from itertools import cycle
from struct import calcsize

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import (
    Activity,
    BatteryLevel,
    BatteryLimits,
    LowBatteryAction,
    Settings,
    Severity,
)
from create_oi_ros.driver.battery_watch import SETTLE
from create_oi_ros.driver.baud_search import BaudSearch, GARBAGE_LIMIT, USUAL_BAUDS
from create_oi_ros.driver.plausibility import FASTEST, FASTEST_TURN, JumpCheck, SLACK
from create_oi_ros.driver.stopping import LAST_WORDS
from create_oi_ros.driver.stream_plan import ALL
from create_oi_ros.driver.supervision import CLEAR_FOR
from create_oi_ros.robot import Rounding
from create_oi_ros.sim.firmware.actuators import DARK, Lights
from support.loop import Loop


def said(loop: Loop, severity: Severity, words: str) -> int:
    """Count the notices of a severity that hold some words."""
    return sum(words in notice.text for notice in loop.notices if notice.severity is severity)


# Calling.


@pytest.mark.parametrize('baud', [code.rate for code in oi.BaudCode if code.rate >= 19200])
def test_the_robot_is_found_at_its_rate(baud):
    loop = Loop(Settings(baud=0), robot_baud=baud)
    loop.run(10)
    assert loop.driver.state.answered
    # Bytes at a wrong rate are garbage, and may happen to be a Baud.
    assert loop.driver.baud == loop.robot.baud
    assert loop.robot.mode is oi.Mode.SAFE


@pytest.mark.parametrize('baud', USUAL_BAUDS)
def test_the_usual_rates_are_found_within_a_second(baud):
    loop = Loop(Settings(baud=0), robot_baud=baud)
    loop.run(1.0)
    assert loop.driver.state.answered


def test_every_rate_is_tried():
    search = BaudSearch(0)
    tried = {search.next_baud() for _ in range(100)}
    assert tried == {code.rate for code in oi.BaudCode}


def test_a_fixed_rate_stays():
    search = BaudSearch(19200)
    assert {search.next_baud() for _ in range(100)} == {19200}


def test_a_silent_robot_is_told_of_once_with_what_to_look_at():
    loop = Loop(Settings(baud=0))
    loop.cut = True
    loop.run(20)
    assert said(loop, Severity.ERROR, 'no answer at 57600 and 19200 baud') == 1


def test_something_else_that_speaks_is_told_of():
    loop = Loop()
    loop.cut = True
    for _ in range(20):
        loop.run(0.1)
        loop.driver.receive(b'$GPGGA,123519,4807' * 2, loop.now)
    assert said(loop, Severity.ERROR, 'not like a Create') == 1
    assert loop.driver.state.activity is Activity.CALLING


def test_a_rate_that_is_too_slow_is_told_of():
    loop = Loop(Settings(baud=9600), robot_baud=9600)
    loop.run(1)
    assert said(loop, Severity.ERROR, '9600 baud is too slow') == 1


@pytest.mark.parametrize('baud', [9600, 14400])
def test_frames_that_are_cut_for_lack_of_room_are_told_of_in_words(baud):
    loop = Loop(Settings(baud=baud), robot_baud=baud)
    loop.run(10)
    assert said(loop, Severity.ERROR, f'{baud} baud is too slow') == 1
    assert 1 <= said(loop, Severity.ERROR, 'frame budget exceeded') <= 2


def every_second_frame(loop: Loop, becomes: Callable[[bytes], bytes]) -> None:
    """Let something become of every second frame."""
    take, second = loop.robot.data_to_send, cycle((False, True))

    def changed() -> bytes:
        frame = take()
        return becomes(frame) if frame and next(second) else frame
    loop.robot.data_to_send = changed


def test_a_line_that_carries_less_than_its_rate_is_told_of_once_and_when_it_is_well_again():
    loop = Loop()
    loop.run(5)
    whole = loop.robot.data_to_send
    every_second_frame(loop, lambda frame: b'')
    loop.run(20)
    assert said(loop, Severity.WARNING, 'frame budget exceeded: only 33 of 67 frames') == 1
    assert loop.driver.health(loop.now).line_problem
    loop.robot.data_to_send = whole
    loop.run(10)
    assert said(loop, Severity.INFO, 'frames arrive in time again') == 1
    assert said(loop, Severity.WARNING, 'frame budget exceeded') == 1
    assert not loop.driver.health(loop.now).line_problem


def test_frames_that_are_damaged_are_not_taken_for_a_slow_line():
    loop = Loop()
    loop.run(5)
    every_second_frame(loop, lambda frame: frame[:-1] + bytes([frame[-1] ^ 1]))
    loop.run(10)
    assert said(loop, Severity.WARNING, 'the others are damaged') == 1
    assert not said(loop, Severity.WARNING, 'frame budget')


@pytest.mark.parametrize('baud', [19200, 57600])
def test_of_a_line_that_is_well_nothing_is_said(baud):
    loop = Loop(Settings(baud=baud), robot_baud=baud, delay=0.05)
    loop.run(1)
    loop.drive(0.2, 0.3, 30)
    assert [notice.text for notice in loop.notices] == ['robot answers; entering SAFE']


def test_noise_in_place_of_frames_is_not_taken_for_a_robot_that_is_off():
    loop = Loop()
    loop.run(1)
    loop.robot.data_to_send = lambda: bytes(60)
    loop.run(1)
    assert said(loop, Severity.ERROR, 'but no frame among them') == 1


def test_a_robot_that_boots_is_met_when_it_is_done():
    loop = Loop()
    loop.run(1)
    loop.robot.power(False, loop.now)
    loop.run(2)
    assert loop.driver.state.activity is Activity.CALLING
    loop.robot.power(True, loop.now)
    loop.run(4.0)
    assert loop.driver.state.answered
    assert loop.robot.mode is oi.Mode.SAFE


# Last words.


@pytest.mark.parametrize('begun', [b'', oi.DriveDirect(right=500, left=500).encode()[:3],
                                   oi.Leds(bits=0, color=0, intensity=0).encode()[:2],
                                   bytes([oi.Song.opcode, 3, 16, 60])])
def test_last_words_stop_a_robot_whatever_it_was_being_told(begun):
    loop = Loop()
    loop.run(0.3)
    loop.drive(0.3, 0.0, 0.5)
    loop.robot.receive(begun + LAST_WORDS, loop.now)
    loop.cut = True
    loop.run(1.0)
    assert loop.robot.mode is oi.Mode.PASSIVE
    assert loop.body.truth().speed == 0


# What cannot be.


def test_an_impossible_jump_is_dropped_and_counted():
    loop = Loop()
    loop.run(1)
    before = loop.estimate
    forged = loop.driver.plan.full
    values = [0] * len(forged.packets)
    values[forged.names.index('distance')] = 4000
    values[forged.names.index('oi_mode')] = oi.Mode.SAFE
    loop.driver.receive(forged.pack_frame(values), loop.now)
    loop.run(0.1)
    assert loop.driver.counts.impossible_jumps == 1
    assert loop.estimate.x == pytest.approx(before.x, abs=1e-6)


def test_what_is_possible_passes():
    jumps = JumpCheck()
    reading = oi.Readings({'distance': 30000, 'angle': 0})
    assert jumps.possible(reading, 0.0), 'the first spans an unknown time'
    reading = oi.Readings({'distance': int(FASTEST * 1000) + SLACK, 'angle': -int(FASTEST_TURN)})
    assert jumps.possible(reading, 1.0)
    assert not jumps.possible(reading, 1.1)


def test_a_reading_out_of_the_manuals_range_is_not_published():
    loop = Loop()
    loop.run(1)
    seen = len(loop.moved)
    forged = loop.driver.plan.full
    values = [0] * len(forged.packets)
    values[forged.names.index('wall')] = 7
    loop.driver.receive(forged.pack_frame(values), loop.now)
    while loop.driver.next_event() is not None:
        seen += 1
    assert seen == len(loop.moved)
    assert loop.driver.counts.implausible_frames == 1


def ruled_out() -> list[tuple[str, int]]:
    """Return each reading with the values next to what the manual allows, as far as they fit."""
    found = []
    for name in ALL:
        wire = oi.PACKETS[oi.NUMBERS[name]].wire
        bits = 8 * calcsize(wire.format)
        least = -2 ** (bits - 1) if wire.format.islower() else 0
        found += [(name, value) for value in (wire.low - 1, wire.high + 1)
                  if least <= value < least + 2 ** bits]
    return found


@pytest.mark.parametrize(('name', 'value'), ruled_out())
def test_no_reading_next_to_the_manuals_range_is_published(name, value):
    loop = Loop()
    loop.run(1)
    forged, before = loop.driver.plan.full, len(loop.moved)
    values = [0] * len(forged.packets)
    values[forged.names.index(name)] = value
    loop.driver.receive(forged.pack_frame(values), loop.now)
    assert loop.driver.next_event() is None
    assert loop.driver.counts.implausible_frames == 1
    assert len(loop.moved) == before


def test_an_angle_that_never_changes_is_told_of():
    # Asked in every frame, a robot that truncates never reports a slow turn.
    loop = Loop(Settings(odometry_window=0.0), rounding=Rounding.TRUNCATE)
    loop.run(0.5)
    loop.drive(0.0, 1.0, 8.0)
    assert said(loop, Severity.WARNING, 'the angle does not change') == 1
    loop.drive(0.0, 3.0, 2.0)
    assert not loop.driver.health(loop.now).angle_stuck


# The battery.


def drained(action: LowBatteryAction) -> Loop:
    """Return a robot with a nearly empty battery, after the driver has noticed."""
    loop = Loop(Settings(battery=BatteryLimits(low=14.0, empty=13.9, action=action)))
    loop.run(0.5)
    loop.body.set_battery(charge=0.02)
    loop.run(SETTLE + 2)
    return loop


def test_a_low_battery_is_told_of_once_and_nothing_is_done_unasked():
    loop = drained(LowBatteryAction.NONE)
    assert loop.driver.health(loop.now).battery is BatteryLevel.EMPTY
    assert said(loop, Severity.WARNING, 'battery') in (1, 2)
    assert loop.robot.mode is oi.Mode.SAFE


def test_on_request_the_robot_stops_in_passive():
    loop = drained(LowBatteryAction.STOP)
    assert loop.robot.mode is oi.Mode.PASSIVE
    loop.drive(0.2, 0.0, 1.0)
    assert loop.body.truth().speed == 0


def test_on_request_the_robot_looks_for_its_dock():
    loop = drained(LowBatteryAction.DOCK)
    assert loop.robot.demo is oi.DemoNumber.COVER_AND_DOCK


def test_a_short_dip_is_no_low_battery():
    loop = Loop(Settings(battery=BatteryLimits(low=14.0, empty=13.9)))
    loop.run(0.5)
    loop.body.set_battery(charge=0.02)
    loop.run(SETTLE / 2)
    loop.body.set_battery(charge=0.9)
    loop.run(SETTLE)
    assert loop.driver.health(loop.now).battery is BatteryLevel.FINE
    assert not said(loop, Severity.WARNING, 'battery')


def test_speech_is_remembered_within_bounds():
    search = BaudSearch(0)
    for _ in range(1000):
        search.add_garbage(bytes(500))
    assert len(search._garbage) <= 2 * GARBAGE_LIMIT


# Commands that the robot did not hear.


def lose_next(loop: Loop, kind: type[oi.Command]) -> None:
    """Let the next command of a kind be lost on its way."""
    receive, code = loop.robot.receive, bytes([kind.opcode])

    def without(data: bytes, now: float, baud: int | None = None) -> None:
        if data.startswith(code):
            data, loop.robot.receive = data[kind.size(data):], receive
        receive(data, now, baud)
    loop.robot.receive = without


def test_a_stop_that_is_lost_is_sent_again():
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    lose_next(loop, oi.DriveDirect)
    loop.run(1.5)
    assert loop.body.truth().speed == 0


def test_a_mode_that_the_robot_did_not_hear_of_is_entered_again():
    loop = Loop()
    loop.run(0.5)
    lose_next(loop, oi.Full)
    loop.driver.set_mode(oi.Mode.FULL, loop.now)
    loop.run(0.5)
    assert loop.robot.mode is oi.Mode.FULL


def test_a_robot_that_misheard_is_brought_back_from_full_to_safe():
    loop = Loop()
    loop.run(0.5)
    loop.robot.receive(oi.Full().encode(), loop.now)
    loop.run(0.5)
    assert loop.robot.mode is oi.Mode.SAFE


@pytest.mark.parametrize('begun', [
    oi.Song(number=0, notes=(oi.Note(60, 10),) * 16).encode()[:3],
    oi.Script(script=bytes(100)).encode()[:2], bytes([oi.Stream.opcode, 255])])
def test_a_robot_in_the_middle_of_a_command_hears_a_stop_within_a_second(begun):
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    loop.robot.receive(begun, loop.now)
    loop.driver.stop(loop.now)
    loop.run(1.5)
    assert loop.body.truth().speed == 0
    assert loop.driver.state.answered


def test_a_robot_that_waits_for_ever_is_told_of_once():
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    loop.robot.receive(oi.WaitEvent(event=oi.Event.PLAY_BUTTON).encode(), loop.now)
    loop.run(5.0)
    assert said(loop, Severity.ERROR, 'ignores commands') == 1


def test_a_robot_that_stands_and_waits_is_told_of_and_told_all_again_when_it_hears():
    loop = Loop()
    loop.run(1)
    pending = loop.driver.outputs.set_leds(oi.LedBits(0), 7, 8)
    loop.run(0.5)
    assert pending.outcome.ok
    loop.robot.receive(oi.WaitTime(time=40).encode(), loop.now)
    loop.run(3.5)
    assert said(loop, Severity.ERROR, 'ignores commands') == 1
    assert not loop.driver.stop(loop.now).outcome.ok
    loop.robot.actuators.lights = DARK
    loop.run(2.5)
    assert not loop.driver.health(loop.now).ignores_commands
    assert loop.robot.actuators.lights == Lights(oi.LedBits(0), 7, 8)
    assert loop.driver.stop(loop.now).outcome == (True, 'wheels stopped', b'')


def test_a_robot_that_was_told_to_wait_is_well_after_it_was_switched_off_and_on():
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    loop.robot.receive(oi.WaitEvent(event=oi.Event.PLAY_BUTTON).encode(), loop.now)
    loop.run(3.0)
    assert said(loop, Severity.ERROR, 'switch it off and on') == 1
    loop.robot.power(False, loop.now)
    loop.run(1.0)
    loop.robot.power(True, loop.now)
    loop.run(5.0)
    assert loop.robot.mode is oi.Mode.SAFE
    assert not loop.driver.health(loop.now).ignores_commands
    assert loop.body.truth().speed == 0


def test_a_robot_that_spoke_before_it_was_called_is_not_said_to_have_left_its_mode():
    loop = Loop(delay=0.03)
    loop.run(1)
    loop.driver.disconnected('cable out')
    loop.driver.connected(loop.now)
    loop.run(1)
    assert not said(loop, Severity.WARNING, 'robot left')
    assert loop.robot.mode is oi.Mode.SAFE


def test_a_demo_that_nobody_asked_for_is_ended():
    loop = Loop()
    loop.run(0.5)
    loop.robot.receive(oi.Demo(demo=oi.DemoNumber.DRIVE_FIGURE_EIGHT).encode(), loop.now)
    loop.run(1.0)
    assert loop.robot.demo is None
    assert loop.body.truth().speed == 0


# A driver that was stopped.


def test_after_a_standstill_what_came_long_ago_is_dropped_and_the_robot_called_anew():
    loop = Loop()
    loop.run(0.5)
    loop.drive(0.3, 0.0, 0.5)
    frames = len(loop.moved)
    stale = loop.driver.plan.short.pack_frame([0] * len(loop.driver.plan.short.packets))
    loop.robot.receive(LAST_WORDS, loop.now)
    loop.cut, receive, poll = True, loop.driver.receive, loop.driver.poll
    loop.driver.poll = lambda now: None
    loop.run(5.0)
    loop.cut, loop.driver.poll = False, poll
    receive(stale * 60, loop.now)
    assert len(loop.moved) == frames
    loop.run(2.0)
    assert loop.estimate.x == pytest.approx(loop.body.truth().pose.x, abs=0.01)
    assert said(loop, Severity.WARNING, 'stood still for 5.0 s') == 1
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.driver.state.answered
    assert loop.body.truth().speed == 0


def test_a_robot_that_cannot_enter_its_mode_at_first_is_not_pestered_and_may_later():
    loop = Loop()
    loop.body.plug_charger(True)
    loop.run(2.0)
    assert loop.driver.status.reason == 'charger powered'
    assert loop.robot.mode is oi.Mode.PASSIVE
    assert sum(isinstance(each, oi.Safe) for each in loop.commands()) <= 2
    loop.body.plug_charger(False)
    loop.run(CLEAR_FOR + 1.0)
    loop.drive(0.2, 0.0, 0.5)
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.body.truth().speed > 0
