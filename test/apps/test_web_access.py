# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The rules of `create_web`: who may open the page, and who drives."""

from math import inf, nan

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
)
from create_oi_ros.driver.goals.goal import Velocity
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
