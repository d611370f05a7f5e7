"""Distance and angle in; pose, twist and covariance out.

Pure arithmetic in SI units and in the odometry frame of REP 105 (x forward at start, y left, yaw
counter-clockwise). `Increment` is what one stream frame says about motion, `Estimate` what is
known after it.
"""

from dataclasses import dataclass
from math import cos, pi, sin


@dataclass(frozen=True, slots=True)
class Geometry:
    """The robot's dimensions and the corrections that calibration found."""

    wheel_separation: float = 0.258
    """Metres between the wheels' contact points."""
    wheel_radius: float = 0.033
    """Metres; only the wheels' joint angles depend on it."""
    linear_scale: float = 1.0
    """True distance over the distance that the robot reports."""
    angular_scale: float = 1.0
    """True angle over the angle that the robot reports."""


@dataclass(frozen=True, slots=True)
class Increment:
    """What one frame says about motion since the frame before."""

    dt: float
    """Seconds since the frame before, by the robot's clock."""
    right: float
    """Requested speed of the right wheel, m/s (packet 41)."""
    left: float
    """Requested speed of the left wheel, m/s (packet 42)."""
    driven: bool
    """Whether the wheels obey these requests: not in a demo, nor after a safety stop."""
    distance: int | None = None
    """Millimetres since it was last asked for (packet 19); None when not asked."""
    angle: int | None = None
    """Degrees since it was last asked for (packet 20); None when not asked."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Pose in the odometry frame, twist in the base frame, wheels, and how sure that is."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    linear: float = 0.0
    """m/s, forward."""
    angular: float = 0.0
    """rad/s, counter-clockwise."""
    pose_covariance: tuple[float, ...] = (1e-9, 0.0, 0.0, 0.0, 1e-9, 0.0, 0.0, 0.0, 1e-9)
    """Row-major over x, y, yaw; m², m rad, rad²."""
    twist_covariance: tuple[float, float] = (1e-6, 1e-6)
    """Variances of linear and angular velocity."""
    right_wheel: float = 0.0
    """Angle of the right wheel, rad, and its speed, rad/s; likewise of the left one."""
    right_wheel_speed: float = 0.0
    left_wheel: float = 0.0
    left_wheel_speed: float = 0.0


class Odometry:
    """Turns increments into an estimate that never jumps."""

    def __init__(self, geometry: Geometry = Geometry(), *, window: float = 0.0) -> None:
        """Ask for distance and angle every `window` seconds; 0 is in every frame."""
        self.geometry = geometry
        self.window = window
        self.estimate = Estimate()
        self._discard = True

    @property
    def reading_due(self) -> bool:
        """Whether the robot should be asked for distance and angle in its next frame."""
        return True

    def reset(self) -> None:
        """Begin again at the origin, at rest."""
        self.estimate = Estimate()

    def interrupted(self) -> None:
        """Go on from here after frames were missed: the next reading spans an unknown time."""
        self._discard = True

    def update(self, increment: Increment) -> Estimate:
        """Take one frame in."""
        if increment.distance is None or increment.angle is None:
            return self.estimate
        if self._discard:
            self._discard = False
            return self.estimate
        g = self.geometry
        distance = increment.distance / 1000 * g.linear_scale
        angle = increment.angle * pi / 180 * g.angular_scale
        self.estimate = self._moved(distance, angle, increment.dt)
        return self.estimate

    def _moved(self, distance: float, angle: float, dt: float) -> Estimate:
        before, g = self.estimate, self.geometry
        middle = before.yaw + angle / 2
        chord = distance * (sin(angle / 2) / (angle / 2) if angle else 1.0)
        right = (distance + angle * g.wheel_separation / 2) / g.wheel_radius
        left = (distance - angle * g.wheel_separation / 2) / g.wheel_radius
        return Estimate(
            x=before.x + chord * cos(middle), y=before.y + chord * sin(middle),
            yaw=before.yaw + angle, linear=distance / dt, angular=angle / dt,
            right_wheel=before.right_wheel + right, right_wheel_speed=right / dt,
            left_wheel=before.left_wheel + left, left_wheel_speed=left / dt)
