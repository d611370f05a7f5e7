# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Waits that never end, and how long scripts take, from the script's own motion."""

import pytest

from create_oi_ros import oi
from create_oi_ros.oi.script import duration, endless_wait
from create_oi_ros.oi.tools.text import parse_script
from create_oi_ros.robot import FIRMWARE_SEPARATION, MM_PER_M

SEPARATION = FIRMWARE_SEPARATION * MM_PER_M


@pytest.mark.parametrize(('text', 'place', 'why'), [
    ('Drive velocity=200 radius=straight; Wait Distance distance=-1000', 2, 'drives forwards'),
    ('Drive velocity=-200 radius=straight; Wait Distance distance=1000', 2, 'drives backwards'),
    ('Drive velocity=0 radius=straight; Wait Distance distance=1000', 2, 'the wheels stand'),
    ('Wait Angle angle=90', 1, 'the wheels stand'),
    ('Drive velocity=200 radius=in_place_clockwise; Wait Angle angle=90', 2, 'turns clockwise'),
    ('Drive velocity=200 radius=in_place_clockwise; Wait Distance distance=9', 2, 'in place'),
    ('Drive velocity=200 radius=straight; Wait Angle angle=90', 2, 'does not turn'),
    ('Drive Direct right=100 left=-100; Wait Angle angle=-90', 2, 'turns counter-clockwise'),
    ('Drive Direct right=1 left=0; Wait Angle angle=-90', 2, 'turns counter-clockwise'),
    ('Drive Direct right=1 left=0; Wait Distance distance=-9', 2, 'drives forwards'),
    ('Drive Direct right=-1 left=0; Wait Distance distance=9', 2, 'drives backwards'),
    ('Drive velocity=200 radius=straight; Wait Time time=5; Start; Wait Distance distance=9',
     4, 'the wheels stand'),
])
def test_a_wait_that_the_motion_does_not_lead_to_never_ends(text, place, why):
    found = endless_wait(parse_script(text), oi.Mode.SAFE, SEPARATION)
    assert found is not None
    assert found.place == place
    assert why in found.why
    assert duration(parse_script(text), oi.Mode.SAFE, SEPARATION) is None


@pytest.mark.parametrize(('text', 'seconds'), [
    ('Drive velocity=300 radius=straight; Wait Distance distance=400; '
     'Drive velocity=0 radius=straight', 4 / 3),
    ('Drive velocity=-200 radius=straight; Wait Distance distance=-100', 0.5),
    ('Drive velocity=100 radius=in_place_clockwise; Wait Angle angle=-90', 2.026),
    ('Wait Time time=20; Wait Distance distance=0', 2.0),
    ('LEDs bits=play color=0 intensity=0', 0.0),
])
def test_how_long_a_script_takes(text, seconds):
    script = parse_script(text)
    assert endless_wait(script, oi.Mode.SAFE, SEPARATION) is None
    assert duration(script, oi.Mode.SAFE, SEPARATION) == pytest.approx(seconds, abs=0.001)


@pytest.mark.parametrize('text', [
    'Wait Event event=bump', 'Wait Time time=1; Play Script', 'Demo demo=cover'])
def test_nobody_knows_how_long_an_event_a_demo_or_a_loop_takes(text):
    script = parse_script(text)
    assert endless_wait(script, oi.Mode.SAFE, SEPARATION) is None
    assert duration(script, oi.Mode.SAFE, SEPARATION) is None


def test_in_passive_a_drive_is_ignored_until_the_script_enters_another_mode():
    drive = 'Drive velocity=200 radius=straight; Wait Distance distance=100'
    found = endless_wait(parse_script(drive), oi.Mode.PASSIVE, SEPARATION)
    assert found is not None and found.why == 'the wheels stand'
    assert endless_wait(parse_script(f'Safe; {drive}'), oi.Mode.PASSIVE, SEPARATION) is None
