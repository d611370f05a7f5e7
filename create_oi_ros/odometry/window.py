"""What happened between two readings, as far as it matters when the second one comes."""

from dataclasses import dataclass


@dataclass(slots=True)
class Window:
    """The time since the accumulators were read."""

    x: float
    """Pose at its beginning."""
    y: float
    yaw: float
    seconds: float = 0.0
    """Its length as far as the covariance has followed."""
    path: float = 0.0
    """Metres that both wheels rolled, in whichever direction, together."""
    expected: float = 0.0
    """Metres that wheels that run free would have been counted had they obeyed."""
    expected_angle: float = 0.0
    miscounted: float = 0.0
    """True travel, metres, less what the encoders make of it; likewise the turn, radians."""
    miscounted_angle: float = 0.0
