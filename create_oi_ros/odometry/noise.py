# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What no unknown explains: process noise, as covariances of the states."""

from typing import NamedTuple

import numpy as np

from ..robot import SLOT
from . import states as s
from .request_history import Array

JITTER = SLOT / 12 ** 0.5
"""Seconds by which a request may take effect earlier or later than the dead time says: it came at
any moment of a frame."""
UNEVEN = 5e-4
"""Part of the path by which steady wheels depart from their goals."""
WANDER = 0.3
"""How fast the gains of wheels drift that do not run steadily: per root second, as a part of what
they stray by per root metre."""
MISCOUNTED = 0.03
"""Part of what was counted with the wrong sign that the model may be wrong by."""
REOPEN = 0.03
"""Part of what was not known of a robot at first that is doubted again in a second of motion that
a track cannot explain."""
FREE_SPEED = 0.3
"""Doubt of the speed of wheels that do not obey, m/s."""
STRAY = 0.09
"""Metres by which wheels that do not obey stray from their counts, per root metre."""
ROAMING, UNWATCHED = 0.0625, 3.0
"""m/s by which the place of a robot is doubted that was not watched for longer than this, s."""
MOVED = slice(s.SPEED_RIGHT, s.SIZE)
"""The states that wheels move: their speeds, right first, the pose, and the accumulators."""
PLACE = slice(s.X - MOVED.start, None)
"""The pose and the accumulators among these."""
GAINS = slice(s.GAIN_RIGHT, s.GAIN_LEFT + 1)
"""The states that drift while wheels do not run steadily."""
SIDES = np.array([[1.0], [-1.0]])
"""In which direction a wheel turns the robot, right first."""
DRIFTS, SPREADS = np.array([(prior.drift, prior.spread) for prior in s.PRIORS]).T ** 2
"""Variances of each state's random walk in a second, and of what is not known of it at first."""
Scales = tuple[float, float]
"""True over counted travel and turn."""


class Stretch(NamedTuple):
    """What the wheels did since the last reading; axes (wheel, track), right first."""

    seconds: float
    changes: Array
    """Sum of the squares of the requests' changes, (m/s)²."""
    unsure: Array
    """Variance of the travel where frames were lost, m²."""
    path: Array
    turned: Array
    """Sum of the squares of the speeds at which encoders took another sign, (m/s)²."""
    miscounted: Array
    """Metres that the encoders counted otherwise than the wheels rolled."""
    free: bool


def along(variance: Array, terms: dict[int, Array | float]) -> Array:
    """Return covariances of disturbances that move several states at once, a matrix a track."""
    g = np.zeros((len(variance), s.SIZE))
    for index, value in terms.items():
        g[:, index] = value
    return variance[:, None, None] * g[:, :, None] * g[:, None, :]


def of_motion(did: Stretch, doubt: Array, heading: Array, width: Array, scales: Scales,
              slip: float, unsteady: Array) -> Array:
    """
    Return what motion adds to the states `MOVED`: uneven wheels, late requests, slip, wrong signs.

    `unsteady`: variance of travel by which wheels stray, m² for each metre.
    """
    travel = doubt * (JITTER ** 2 * did.changes[:, None] + (UNEVEN * did.path) ** 2)
    travel = travel + unsteady * did.path + did.unsure[:, None]
    if did.free:
        travel += (FREE_SPEED * did.seconds) ** 2
    wrong = doubt * ((MISCOUNTED * did.miscounted) ** 2 + (2 * JITTER) ** 2 * did.turned)
    return _of_wheels(
        np.array([slip * slip * did.path, travel, wrong]), heading, width, scales,
        did.free / max(did.seconds, SLOT))


def of_age(seconds: float, path: Array, doubt: Array, unsteady: Array) -> Array:
    """Return the variances that motion adds to states that drift; axes (track, state)."""
    if not path[:, 0].any():
        return np.zeros((len(doubt), s.SIZE))
    again = REOPEN * np.minimum(np.maximum(doubt - 1, 0), 10) / 10
    variances: Array = seconds * (DRIFTS + again[:, None] * SPREADS)
    variances[:, GAINS] += seconds * WANDER ** 2 * unsteady[:, None]
    return variances


def _of_wheels(variances: Array, heading: Array, width: Array, scales: Scales,
               speed: float) -> Array:
    """
    Return the covariances of the states `MOVED`, a matrix a track.

    `variances`: of a wheel's slip, its travel and its miscounting, axes (kind, wheel, track); a
    wheel's travel changes its speed by `speed` for each metre.
    """
    linear, angular = scales
    kinds: Array = np.zeros((3, 2, len(width), s.SIZE - MOVED.start))
    slip, travel, wrong = kinds
    slip[:, :, s.X - MOVED.start] = linear / 2 * np.cos(heading)
    slip[:, :, s.Y - MOVED.start] = linear / 2 * np.sin(heading)
    turn = SIDES / width
    slip[:, :, s.YAW - MOVED.start] = angular * turn
    wrong[:, :, s.DISTANCE - MOVED.start] = 0.5
    wrong[:, :, s.ANGLE - MOVED.start] = turn
    travel[:] = slip + wrong
    travel[0, :, 0] = travel[1, :, 1] = speed
    g = kinds.reshape(6, len(width), -1).transpose(1, 2, 0)
    q: Array = (g * variances.reshape(6, -1).T[:, None]) @ g.transpose(0, 2, 1)
    return q


def of_surprise(distance: Array, angle: Array, heading: Array, scales: Scales) -> Array:
    """Return doubt of the travel and the turn since the last reading, of these variances."""
    linear, angular = scales
    return (along(distance, {s.X: linear * np.cos(heading), s.Y: linear * np.sin(heading),
                             s.DISTANCE: 1.0})
            + along(angle, {s.YAW: angular, s.ANGLE: 1.0}))


def of_roaming(distance: float, turn: float, width: float, seconds: float,
               scales: Scales) -> Array:
    """Return doubt of the way of a robot that went its own: only its two ends were seen."""
    linear, angular = scales
    way = STRAY ** 2 * (abs(distance) + abs(turn) * width / 2)
    place = way / 2 + (ROAMING * seconds if seconds > UNWATCHED else 0.0) ** 2
    q = np.zeros((s.SIZE, s.SIZE))
    q[s.X, s.X] = q[s.Y, s.Y] = linear ** 2 * place
    q[s.YAW, s.YAW] = angular ** 2 * 2 * way / width ** 2
    return q
