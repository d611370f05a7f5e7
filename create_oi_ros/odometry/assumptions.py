"""What the tracks take for granted: SI units, standard deviations unless it says otherwise."""

from math import pi

MM = 1e-3
DEGREE = pi / 180
GAIN_SPREAD, SEPARATION_SPREAD = 0.02, 0.006
"""Standard deviations of gain and separation at the start, relative."""
RAMP_SPREAD = 0.25
"""Standard deviation around one first guess of the acceleration, relative."""
LAG_SPREAD = 0.005
"""Standard deviation of the lag at the start, in seconds."""
GAINS, SEPARATIONS, ACCELERATIONS = (0.92, 1.08), (0.252, 0.264), (0.1, 10.0)
"""What no lesson goes beyond: m, m/s²."""
HALF_SLOT = 0.0075
JITTER = 1 / 16
"""Variance, in squared slots, of the moment at which a request takes effect, about the learned
lag; 1/12 would be any moment, and 0 always the same."""
GAIN_DRIFT = 1e-4
"""Standard deviation of a gain's random walk, per root second of motion."""
ASTRAY = 0.09
"""Metres by which a wheel that is not driven as requested strays from its encoder, per root metre:
nobody knows when it reverses, and its encoder counts on with the old sign."""
TOP_SPEED = 0.5
"""m/s, of either wheel (manual)."""
RAMP_NOISE = 0.002
"""Part of a ramp's travel by which it departs from a constant acceleration."""
UNWATCHED = 3.0
"""Seconds after which a robot that moved on its own may have gone anywhere between two readings,
whatever their sum."""
ROAMING = TOP_SPEED / 8
"""Growth of the doubt about the place of such a robot, m/s."""
WANDER = 0.5
"""Acceleration of a robot that moves on its own, m/s per root second."""
SURPRISE, SURPRISE_FLOOR = 5.0, 0.1
"""Standard deviations, and units added to them, beyond which prediction has failed."""
CERTAIN = 1e-14
"""Variance, m² or rad², of what is known exactly: more would be numerical trouble."""
UNLIKELY = 1e-2
"""Likelihood that is left to a reading that ought not to be."""
LONGEST_SEGMENT = 0.25
"""Seconds between updates of the covariance."""
EXPLICABLE = 3.0, 0.15
"""Units, and part of the path, by which wrong parameters may make prediction fail."""
BELIEVABLE = 2.0, 0.05
"""Units, and part of the travel, by which a robot that obeys again may miss its prediction."""
TELLING_TIME = 0.2
"""Seconds that a window must last to show that a robot obeys again."""
