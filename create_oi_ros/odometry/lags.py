# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Wheels that run to their goals by an exponential lag whose acceleration is bounded.

With a time constant T and an acceleration a, the way E to the goal shrinks at the rate
min(E / T, a). `ramp` is 1 / a, in s²/m. Arrays are those of `wheel_model`.
"""

import numpy as np
from numpy.typing import NDArray

from .request_history import Array

SLOWEST, MIDDLE, FASTEST = 0.05, 0.076, 0.5
"""m/s between which a lag depends on the speed, as one over it: by one part below the middle, by
another above."""
Bounds = tuple[Array, Array]
"""Lag and ramp of each copy of each wheel."""
Motion = tuple[Array, Array]
"""Speeds in the end, and travel."""


def bounded(goal: Array, way: Array, h: float | Array, bounds: Bounds) -> Motion:
    """Let wheels follow for h seconds that have a way to go to their goals."""
    # In place, for these arrays are large: `first`, the seconds at full acceleration; `left`, the
    # way that is left after them; `kept`, what is left at the end; `short`, the travel that a
    # wheel at its goal would have made beyond this one's.
    lag, ramp = bounds
    first = np.abs(way)
    first *= ramp
    first -= lag
    np.minimum(np.maximum(first, 0.0, out=first), h, out=first)
    left = way - np.copysign(first / ramp, way)
    kept = first - h
    kept /= lag
    np.exp(kept, out=kept)
    kept *= left
    short: Array = way + left
    short *= first
    short /= 2
    left -= kept
    left *= lag
    short += left
    return goal - kept, goal * h - short


def braked(goal: Array, speed: Array, braking: NDArray[np.bool_], h: float | Array,
           usual: Bounds, softer: Bounds) -> Motion:
    """Let wheels follow for h seconds of which some brake, with other bounds, until they stop."""
    lag, ramp = (np.where(braking, brake, drive) for brake, drive in zip(softer, usual))
    after, travel = bounded(goal, goal - speed, h, (lag, ramp))
    back = after * speed < 0
    if np.count_nonzero(back):  # these stop and turn back within the step
        at = back.nonzero()
        after[at], travel[at] = _turned_back(
            goal[at], speed[at], after[at], h if isinstance(h, float) else h[at[1:]],
            (softer[0][at], softer[1][at]), (usual[0][at], usual[1][at]))
    return after, travel


def _turned_back(goal: Array, speed: Array, after: Array, h: float | Array, softer: Bounds,
                 usual: Bounds) -> Motion:
    stops = h * speed / (speed - after)
    halted, there = bounded(goal, goal - speed, stops, softer)
    after, back = bounded(goal, goal - halted, h - stops, usual)
    return after, there + back

def lag_parts(speed: float) -> tuple[float, float]:
    """Return how much of the parts of a lag counts that slow and fast wheels have, 0 to 1."""
    slow = (1 / min(max(speed, SLOWEST), MIDDLE) - 1 / MIDDLE) / (1 / SLOWEST - 1 / MIDDLE)
    fast = (1 / MIDDLE - 1 / max(speed, MIDDLE)) / (1 / MIDDLE - 1 / FASTEST)
    return slow, fast
