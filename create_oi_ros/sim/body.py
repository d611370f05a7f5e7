"""
The robot's body: wheels, encoders, bumper, sensors, battery, in a world.

Firmware's side.  Construct `Body(world, rounding=..., seed=..., config=...)`; give it wheel
speeds with `drive`, duty cycles with `low_side`, permission with `allow_charging`; let time pass
with `step(dt)`; look with `sense()`, `take_distance()`, `take_angle()`.

    body.drive(right=0.2, left=0.2)
    body.step(0.015)
    readings = body.sense()          # a `Readings`, cached until something changes
    millimetres = body.take_distance()

For script waits note `distance_total` or `angle_total` at the start, call `take_distance` or
`take_angle` to reset what packets 19 and 20 will say, and compare as time goes on.

The outside's side (a test, a teacher, the control channel): `press`, `lift`, `drop`, `hold`,
`push`, `slip`, `place`, `plug_charger`, `set_charge`, `load`, `force`, `unforce`, `truth`.

Nothing here knows a clock: the same calls with the same seed give the same robot.
SI units, x forward, yaw counter-clockwise; only `Readings` speaks the manual's units.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from create_oi_ros.sim.config import BodyConfig
from create_oi_ros.sim.drivetrain import Drivetrain, Motion
from create_oi_ros.sim.encoders import Accumulator, Rounding
from create_oi_ros.sim.readings import Readings, checked
from create_oi_ros.sim.world import Pose, World

_LONGEST_PIECE = 0.015
"""Seconds: at 0.5 m/s 7.5 mm, so no wall is jumped."""
_SHORTEST_PIECE = 1e-9


class Truth(NamedTuple):
    """What really happened, for teachers and tests; no firmware may look at it."""

    pose: Pose
    """World frame; yaw within -pi to pi."""
    speed: float
    """True forward velocity, m/s."""
    rate: float
    """True yaw rate, rad/s."""
    travelled: float
    """True signed travel of the centre along its heading, metres."""
    turned: float
    """True turn, radians, unwrapped."""
    measured_travelled: float
    """The same by the encoders, before any rounding, metres."""
    measured_turned: float
    """The same by the encoders, before any rounding, radians."""


class Body:
    """A Create's mechanics, sensors and battery."""

    __slots__ = ('config', 'world', '_time', '_pose', '_wheels', '_distance', '_angle',
                 '_speed', '_rate', '_travelled', '_turned', '_push', '_forced', '_sensed',
                 '_charging_allowed', '_duties', '_lifted', '_dropped')

    def __init__(self, world: World, *, rounding: Rounding = Rounding.TRUNCATE, seed: int = 0,
                 config: BodyConfig = BodyConfig()) -> None:
        self.config = config
        self.world = world
        self._time = 0.0
        self._pose = world.start
        self._wheels = Drivetrain(config)
        self._distance = Accumulator(rounding)
        self._angle = Accumulator(rounding)
        self._speed = self._rate = self._travelled = self._turned = 0.0
        self._push = (0.0, 0.0, 0.0)
        self._forced: dict[str, tuple[int, float]] = {}
        self._sensed: Readings | None = None
        self._charging_allowed = True
        self._duties = (0.0, 0.0, 0.0)
        self._lifted = False

    # What the firmware commands.

    def drive(self, *, right: float, left: float) -> None:
        """Set the target wheel speeds, m/s, clamped to the wheels' maximum (0.5)."""
        self._wheels.right.command(right)
        self._wheels.left.command(left)

    def low_side(self, *, duty0: float, duty1: float, duty2: float) -> None:
        """Set the low side drivers' duty cycles, clamped to 0 to 1."""
        self._duties = (min(1.0, max(0.0, duty0)), min(1.0, max(0.0, duty1)),
                        min(1.0, max(0.0, duty2)))
        self._sensed = None

    def allow_charging(self, allowed: bool) -> None:
        """Let a charging source charge the battery: true in Off and Passive only."""
        self._charging_allowed = allowed
        self._sensed = None

    def power(self, on: bool) -> None:
        """Switch the robot's electronics; off, the wheels are not driven.  Starts on."""
        if not on:
            self.drive(right=0.0, left=0.0)
            self.low_side(duty0=0.0, duty1=0.0, duty2=0.0)

    def step(self, dt: float) -> None:
        """Let dt seconds pass: finite, not negative; cut inside as finely as the physics needs."""
        if not 0 <= dt < math.inf:
            raise ValueError(f'dt is {dt}: seconds, finite and not negative, are wanted')
        while dt > _SHORTEST_PIECE:
            dt -= self._piece(dt)

    # What the firmware reads.

    def sense(self) -> Readings:
        """Return all sensors as they are now; forced values last; cached until a change."""
        if self._sensed is None:
            self._sensed = Readings()._replace(
                **{name: value for name, (value, _) in self._forced.items()})
        return self._sensed

    def take_distance(self) -> int:
        """Packet 19: millimetres since the last call, -32768 to 32767; the call resets it."""
        return self._distance.take()

    def take_angle(self) -> int:
        """Packet 20: degrees counter-clockwise since the last call; the call resets it."""
        return self._angle.take()

    @property
    def distance_total(self) -> float:
        """Millimetres by the encoders since the start, signed, unrounded; never reset."""
        return self._distance.total

    @property
    def angle_total(self) -> float:
        """Degrees by the encoders since the start, signed, unrounded; never reset."""
        return self._angle.total

    # What the outside does.

    def truth(self) -> Truth:
        """Return what really happened."""
        return Truth(self._pose, self._speed, self._rate, self._travelled, self._turned,
                     self._distance.total / 1000, math.radians(self._angle.total))

    def place(self, pose: Pose) -> None:
        """Put the robot elsewhere, without turning its wheels."""
        self._pose = pose
        self._sensed = None

    def push(self, *, speed: float, rate: float, seconds: float) -> None:
        """Roll the robot by hand at m/s and rad/s for some seconds; the wheels follow."""
        self._push = (speed, rate, self._time + seconds)

    def force(self, *, seconds: float = math.inf, **values: int) -> None:
        """
        Overlay sensors of `Readings` with values, for some seconds or until `unforce`.

        force(bump_left=True), force(seconds=0.2, play=True), force(infrared=130), ...
        ValueError names a field that is not there or a value out of its range.
        """
        held = {name: (checked(name, value), self._time + seconds)
                for name, value in values.items()}
        self._forced.update(held)
        self._sensed = None

    def unforce(self, *names: str) -> None:
        """Give the named sensors (without names: all) back to the physics."""
        for name in names or tuple(self._forced):
            checked(name, 0)
            self._forced.pop(name, None)
        self._sensed = None

    # Physics.

    def _piece(self, longest: float) -> float:
        """Move by the longest time that is simple; return its seconds."""
        h = self._wheels.horizon(min(longest, _LONGEST_PIECE))
        self._moved(h, self._wheels.advance(h, self._pose.yaw))
        self._time += h
        self._sensed = None
        return h

    def _moved(self, h: float, motion: Motion) -> None:
        x, y, yaw = self._pose
        self._pose = Pose(x + motion.dx, y + motion.dy,
                          math.remainder(yaw + motion.turn, math.tau))
        self._travelled += motion.travel
        self._turned += motion.turn
        self._distance.add(500 * (motion.counted_right + motion.counted_left))
        self._angle.add(math.degrees((motion.counted_right - motion.counted_left)
                                     / self.config.encoder_separation))
