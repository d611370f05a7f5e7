# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Scripts byte for byte and to the hundredth of a second: stored, played, watched, read back."""

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, Driver
from create_oi_ros.driver.outbox import HALT
from create_oi_ros.oi.script import build_script
from support.typed_frames import answered, heard, LAST, notices, polled

SCRIPT = build_script([oi.DriveDirect(right=100, left=100), oi.WaitTime(time=20),
                       oi.DriveDirect(right=0, left=0)])
NOW = LAST + 0.1


def words(*commands: oi.Command) -> bytes:
    """Return the bytes of commands."""
    return b''.join(command.encode() for command in commands)


def stored(script: oi.Script = SCRIPT) -> Driver:
    """Return a driver that has stored a script."""
    driver = answered()
    request = driver.scripts.define(script)
    assert words(script) in polled(driver, NOW - 0.05)
    polled(driver, NOW - 0.04)
    assert request.outcome.ok
    return driver


def playing(script: oi.Script = SCRIPT, *, force: bool = False) -> Driver:
    """Return a driver whose script plays since NOW."""
    driver = stored(script)
    assert driver.scripts.play(NOW, force=force).outcome is None
    assert polled(driver, NOW) == words(
        oi.Drive(velocity=0, radius=oi.Radius.STRAIGHT), oi.Stream(packets=driver.plan.script.ids),
        oi.PlayScript())
    return driver


def watched(driver: Driver, *times: float) -> bytes:
    """Let frames of a robot that plays come; return what it is told at the last moment."""
    for now in times:
        heard(driver, now, driver.plan.script)
        sent = polled(driver, now)
    return sent


def test_a_robot_that_plays_is_asked_once_and_then_by_two_bytes_whether_it_listens():
    driver, pause = playing(), words(oi.PauseResumeStream(state=oi.StreamState.PAUSE))
    asks = words(HALT, oi.Stream(packets=driver.plan.marker.ids))
    assert watched(driver, NOW + 0.1, NOW + 0.19) == b''
    assert watched(driver, NOW + 0.21) == asks
    assert watched(driver, NOW + 0.3, NOW + 0.4) == b''
    assert watched(driver, NOW + 1.0, NOW + 1.5, NOW + 2.05) == b''
    assert watched(driver, NOW + 2.2) == pause
    assert watched(driver, NOW + 2.25) == b''
    assert watched(driver, NOW + 2.31) == words(
        oi.PauseResumeStream(state=oi.StreamState.RESUME))
    assert watched(driver, NOW + 2.41) == pause
    assert polled(driver, NOW + 2.5) == b''
    assert polled(driver, NOW + 2.52) == asks
    assert driver.state.activity is Activity.SCRIPT
    heard(driver, NOW + 2.55, driver.plan.marker)
    assert driver.state.activity is Activity.IDLE
    assert 'the script has ended; wheels stopped' in [text for _, text in notices(driver)]


@pytest.mark.parametrize(('later', 'says'), [
    (0.0, 'for about 2 s more'), (1.2, 'for about 1 s more'), (9.0, 'for about 0 s more')])
def test_it_is_said_how_long_a_script_still_plays(later, says):
    driver = playing()
    assert says in driver.scripts.status(NOW + later)
    assert driver.scripts.status(NOW + later).startswith(driver.state.refusal)
    assert stored().scripts.status(NOW) is None


def test_of_a_script_without_an_end_nobody_knows_how_long_it_plays():
    endless = build_script([oi.WaitTime(time=1), oi.PlayScript()])
    driver = stored(endless)
    refused = driver.scripts.play(NOW, force=False).outcome
    assert not refused.ok and 'plays itself again and may never end' in refused.text
    assert 'for an unknown time' in playing(endless, force=True).scripts.status(NOW)


def test_a_script_that_is_not_known_or_not_there_is_not_played():
    for driver, says in ((answered(), 'the stored script is not known'),
                         (stored(oi.Script(script=b'')), 'no script is stored')):
        assert says in driver.scripts.play(NOW, force=False).outcome.text
        assert polled(driver, NOW) == b''
    assert answered().scripts.play(NOW, force=True).outcome is None
    assert not answered().scripts.define(oi.Script(script=b'\x89')).outcome.ok
    driver = stored()
    driver.scripts.forget()
    assert 'is not known' in driver.scripts.play(NOW, force=False).outcome.text


def test_a_wait_without_an_end_is_named():
    waits = build_script([oi.WaitTime(time=1), oi.WaitDistance(distance=100)])
    text = stored(waits).scripts.play(NOW, force=False).outcome.text
    assert text.startswith('command 2 of the stored script, Wait Distance distance=100, waits')


def shown() -> tuple[Driver, object]:
    """Return a driver that has asked for the stored script, and the request."""
    driver = answered()
    request = driver.scripts.show(NOW)
    assert driver.state.activity is Activity.SILENCING
    assert polled(driver, NOW) == words(oi.PauseResumeStream(state=oi.StreamState.PAUSE))
    assert polled(driver, NOW + 0.05, NOW + 0.09) == b''
    assert driver.state.activity is Activity.SILENCING
    assert polled(driver, NOW + 0.11) == words(oi.ShowScript())
    assert driver.state.activity is Activity.READING
    return driver, request


def test_a_script_is_read_back_once_the_line_is_silent():
    driver, request = shown()
    reply = bytes([len(SCRIPT.script)]) + SCRIPT.script
    driver.receive(reply[:5], NOW + 0.2)
    driver.receive(reply[5:-1], NOW + 0.25)
    assert request.outcome is None
    driver.receive(reply[-1:], NOW + 0.26)
    assert request.outcome == (True, '12 of 100 bytes', SCRIPT.script)
    assert driver.state.activity is Activity.IDLE
    assert driver.scripts.play(NOW + 0.3, force=False).outcome is None  # it is known now


def test_a_reply_may_take_half_a_second_and_its_bytes():
    """A hundred bytes and their count take 17.5 ms at 57600 baud."""
    driver, request = shown()
    driver.receive(b'\x09\x80', NOW + 0.2)
    polled(driver, NOW + 0.3, NOW + 0.62)
    assert request.outcome is None
    polled(driver, NOW + 0.632)
    assert request.outcome.ok is False
    assert request.outcome.text == (
        'the robot sent 2 bytes of its script and then nothing: try again')
    assert driver.state.activity is Activity.IDLE


def test_an_empty_reply_is_an_empty_script_and_a_damaged_one_is_said():
    driver, request = shown()
    driver.receive(b'\0', NOW + 0.2)
    assert request.outcome == (True, 'no script is stored', b'')
    driver, request = shown()
    driver.receive(b'\xc8' + bytes(200), NOW + 0.2)
    assert request.outcome.ok is False
    assert request.outcome.text.startswith('the reply came damaged (')


def test_a_robot_that_is_lost_while_it_sends_its_script_ends_the_request():
    driver, request = shown()
    driver.disconnected('cable out')
    assert request.outcome.text == 'the robot was lost while it sent its script'


@pytest.mark.parametrize(('script', 'says'), [
    (SCRIPT, '12 of 100 bytes'), (oi.Script(script=b''), 'no script is stored'),
    (build_script([oi.PlayScript()]), '1 of 100 bytes; it plays itself again and may never end'),
    (build_script([oi.WaitEvent(event=oi.Event.BUMP)]),
     '2 of 100 bytes; it ends only if this happens: Wait Event event=bump')])
def test_what_is_stored_is_described(script, says):
    driver = answered()
    request = driver.scripts.define(script)
    polled(driver, NOW, NOW + 0.05)
    assert request.outcome.text.lower() == f'sent: {says.lower()}'
