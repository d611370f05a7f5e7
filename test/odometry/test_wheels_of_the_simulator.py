# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Tracks that know simulated wheels follow them for a minute without a reading."""

from collections.abc import Iterator
from dataclasses import replace
from math import degrees, hypot, log, pi
from random import Random

import pytest

from create_oi_ros.odometry import Geometry
from create_oi_ros.odometry import states as s
from create_oi_ros.odometry.assumptions import Assumptions
from create_oi_ros.odometry.dead_band import DeadBand
from create_oi_ros.odometry.encoder_signs import LAST
from create_oi_ros.odometry.lags import FASTEST, MIDDLE, SLOWEST
from create_oi_ros.odometry.tracks import Tracks
from create_oi_ros.robot import FIRMWARE_SEPARATION
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import BodyConfig
from create_oi_ros.sim.body.wheels import Response, TimeConstant
from create_oi_ros.sim.world import World
from support.bodies import LAGGING
from support.ride import SLOT

SECONDS, LIMIT = 60.0, 0.5
"""How long to drive, and by how much the requests change in a second, m/s."""
SURE = 1e-6
LOOK = 33
"""Frames from one look to the next, for a look makes the wheels roll at once."""
MOST_FAR, MOST_TURNED = 3.0, 1.0
"""mm and degrees that these may be off, of about four metres and four turns."""
STEADY = replace(LAGGING, dead_band=0.0, encoder_tick=0.0)


def known(config: BodyConfig) -> Assumptions:
    """Return the one track whose wheels are those of a body."""
    is_spring = config.response is Response.SECOND_ORDER
    rows = Assumptions.all()
    rows.keep([next(i for i in range(len(rows.springs)) if rows.springs[i] == is_spring
                    and rows.signs.kinds[i] == LAST and rows.signs.late[i])])
    slow, middle, fast = map(config.time_constant.at, (SLOWEST, MIDDLE, FASTEST))
    damping = -log(config.overshoot) / hypot(pi, log(config.overshoot))
    believed = {
        s.GAIN_RIGHT: config.right_speed_gain, s.GAIN_LEFT: config.left_speed_gain,
        s.LAG: middle * (2 * damping if is_spring else 1.0),
        s.SLOW_LAG: slow / middle - 1, s.FAST_LAG: 1 - fast / middle,
        s.DEAD_TIME: config.dead_time, s.BRAKING: log(config.braking),
        s.RAMP: damping if is_spring else 0.0,
        s.SEPARATION: config.encoder_separation / FIRMWARE_SEPARATION - 1}
    if config.response is Response.RAMP:
        believed |= {s.LAG: 0.0, s.RAMP: 1 / config.wheel_acceleration}
    for index, value in believed.items():
        rows.clear(index, value)
    rows.p[:, range(s.UNKNOWNS), range(s.UNKNOWNS)] = SURE ** 2
    return rows


def requests() -> Iterator[tuple[float, float]]:
    """Yield what both wheels are asked in each frame, m/s: as the driver's limits let them."""
    random, speeds, left = Random(3), [0.0, 0.0], 0
    goals = [0.0, 0.0]
    for _ in range(round(SECONDS / SLOT)):
        if not left:
            left = random.randint(20, 200)
            goals = [random.choice((0.0, random.uniform(-0.4, 0.4), random.uniform(0.02, 0.1)))
                     for _ in speeds]
        left -= 1
        most = LIMIT * SLOT
        speeds = [speed + max(-most, min(most, goal - speed))
                  for speed, goal in zip(speeds, goals)]
        yield speeds[0], speeds[1]


@pytest.mark.parametrize('config', [
    STEADY,
    replace(STEADY, time_constant=TimeConstant(0.2), braking=0.5),
    replace(STEADY, time_constant=TimeConstant(0.2, 1.0, fastest=0.5), dead_time=0.12),
    replace(STEADY, response=Response.RAMP, wheel_acceleration=0.4, braking=2.0),
    replace(STEADY, response=Response.SECOND_ORDER, time_constant=TimeConstant(0.08, 1.0),
            overshoot=0.2)],
    ids=['centre', 'one lag', 'fast lags', 'ramp', 'spring'])
def test_wheels_that_are_known_are_followed_without_readings(config: BodyConfig) -> None:
    body = Body(World(), config=config, seed=1)
    tracks = Tracks(Geometry(), known(config), DeadBand(0.0, 0.0))
    off = []
    for frame, (right, left) in enumerate(requests()):
        body.drive(right=right, left=left)
        body.step(SLOT)
        tracks.advance(SLOT, right, left)
        if frame % LOOK == 0:
            distance, angle = tracks.held
            off.append((1000 * distance - body.distance_total, degrees(angle) - body.angle_total))
    far, turned = (max(map(abs, each)) for each in zip(*off))
    assert far < MOST_FAR and turned < MOST_TURNED
