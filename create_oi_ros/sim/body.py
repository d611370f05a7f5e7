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

The outside's side (a test, a teacher, the control channel): `force` and `unforce` any sensor
(bumper, buttons, infrared, cliffs, analog and digital inputs ...), `place`, `push`, `lift`,
`drop`, `hold`, `slip`, `plug_charger`, `power_home_base`, `set_battery`, `load`, and `truth`.

Nothing here knows a clock: the same calls with the same seed give the same robot.
SI units, x forward, yaw counter-clockwise; only `Readings` speaks the manual's units.
"""

from __future__ import annotations

import math
from random import Random
from typing import NamedTuple

from create_oi_ros.sim import surroundings
from create_oi_ros.sim.config import BodyConfig, Contact
from create_oi_ros.sim.drivetrain import Drivetrain, Motion, Wheel
from create_oi_ros.sim.electrics import Electrics
from create_oi_ros.sim.encoders import Accumulator, Rounding
from create_oi_ros.sim.overlay import Overlay
from create_oi_ros.sim.readings import clamped, Readings
from create_oi_ros.sim.world import Pose, World

_LONGEST_PIECE = 0.015
"""Seconds: at 0.5 m/s 7.5 mm, so no wall is jumped."""
_BLOCKED = 0.5
"""Part of the way lost to an obstacle from which the motors labour (guess)."""
_MOMENT = 1e-9
"""Seconds by which a sum of times may miss a deadline."""


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

    __slots__ = ('config', 'world', '_time', '_deadline', '_pose', '_travelled', '_turned',
                 '_surroundings', '_wheels', '_distance', '_angle', '_lost', '_electrics',
                 '_overlay', '_sensed', '_random', '_lifted', '_dropped', '_caster_grounded',
                 '_push', '_push_end', '_slip_end')

    def __init__(self, world: World, *, rounding: Rounding = Rounding.TRUNCATE, seed: int = 0,
                 config: BodyConfig = BodyConfig()) -> None:
        self.config = config
        self.world = world
        self._time, self._deadline = 0.0, math.inf
        self._pose = world.start
        self._travelled = self._turned = 0.0
        self._surroundings = surroundings.Surroundings(world, config.body_radius)
        self._wheels = Drivetrain(config)
        self._distance, self._angle = Accumulator(rounding), Accumulator(rounding)
        self._lost = 0.0
        self._electrics = Electrics(config.battery)
        self._overlay = Overlay()
        self._sensed: Readings | None = None
        self._random = Random(seed)
        self._lifted = False
        self._dropped = (False, False, False)
        self._caster_grounded = True
        self._push = (0.0, 0.0)
        self._push_end = self._slip_end = math.inf
        self.place(world.start)

    # What the firmware commands.

    def drive(self, *, right: float, left: float) -> None:
        """Set the target wheel speeds, m/s, clamped to the wheels' maximum (0.5)."""
        self._wheels.right.command(right)
        self._wheels.left.command(left)
        self._sensed = None

    def low_side(self, *, duty0: float, duty1: float, duty2: float) -> None:
        """Set the low side drivers' duty cycles, clamped to 0 to 1."""
        self._electrics.duties = tuple(map(_fraction, (duty0, duty1, duty2)))
        self._sensed = None

    def allow_charging(self, allowed: bool) -> None:
        """Let a charging source charge the battery: true in Off and Passive only."""
        self._electrics.charging_allowed = allowed

    def power(self, on: bool) -> None:
        """Switch the robot's electronics; off, nothing is driven.  A charger works either way."""
        self._electrics.on = on
        if not on:
            self.drive(right=0.0, left=0.0)
            self.low_side(duty0=0.0, duty1=0.0, duty2=0.0)

    def step(self, dt: float) -> None:
        """Let dt seconds pass: finite, not negative; cut inside as finely as the physics needs."""
        if not 0 <= dt < math.inf:
            raise ValueError(f'dt is {dt}: seconds, finite and not negative, are wanted')
        while dt > 0:
            dt -= self._piece(dt)

    # What the firmware reads.

    def sense(self) -> Readings:
        """Return all sensors as they are now, forced values over them; cached until a change."""
        if self._sensed is None:
            self._sensed = self._overlay.over(self._look())
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

    @property
    def battery_flat(self) -> bool:
        """Whether no charge is left: a real robot is off then."""
        return self._electrics.battery.charge <= 0

    # What the outside does.

    def truth(self) -> Truth:
        """Return what really happened."""
        pushed = self._push_end < math.inf and not self._lifted
        speed, rate = self._push if pushed else self._wheels.twist()
        return Truth(self._pose, speed * (1 - self._lost), rate, self._travelled, self._turned,
                     self._distance.total / 1000, math.radians(self._angle.total))

    def force(self, *, seconds: float = math.inf, **values: int) -> None:
        """
        Hold sensors of `Readings` at values, for some seconds or until `unforce`.

        force(bump_left=True), force(seconds=0.2, play=True), force(infrared=130), ...
        ValueError names a field that is not there or a value out of its range; then none is held.
        """
        self._overlay.force(values, _after(self._time, seconds))
        self._set_deadline()
        self._sensed = None

    def unforce(self, *names: str) -> None:
        """Give the named sensors (without names: all) back to the physics."""
        if names:
            self._overlay.release(names)
        else:
            self._overlay.release_all()
        self._set_deadline()
        self._sensed = None

    def place(self, pose: Pose) -> None:
        """Put the robot elsewhere without turning its wheels; obstacles push it out."""
        _finite('a pose', *pose)
        self._pose = pose._replace(yaw=math.remainder(pose.yaw, math.tau))
        self._lost = 0.0
        self._surroundings.move_to(pose.x, pose.y)
        free = None if self._lifted else self._surroundings.push_out(pose.x, pose.y,
                                                                     (pose.x, pose.y))
        if free is not None:
            self._pose = self._pose._replace(x=free[0], y=free[1])
        self._stand()

    def push(self, *, speed: float, rate: float, seconds: float) -> None:
        """Roll the robot by hand at m/s and rad/s for some seconds; the wheels must follow."""
        _finite('a push', speed, rate, seconds)
        self._push_end = _after(self._time, seconds)
        self._push = (speed, rate)
        self._set_deadline()

    def slip(self, *, right: float, left: float, seconds: float) -> None:
        """For some seconds let the wheels lose these parts, 0 to 1, of their travel."""
        _finite('a slip', right, left, seconds)
        self._slip_end = _after(self._time, seconds)
        self._wheels.right.slip, self._wheels.left.slip = _fraction(right), _fraction(left)
        self._set_deadline()

    def lift(self, lifted: bool) -> None:
        """Lift the robot, or put it down: all wheels drop, no floor is seen, nothing moves it."""
        self._lifted = lifted
        self.place(self._pose)

    def drop(self, *, right: bool = False, left: bool = False, caster: bool = False) -> None:
        """Say which wheels hang down by hand; a drive wheel that does has no grip."""
        self._dropped = (right, left, caster)
        self._stand()

    def hold(self, *, right: bool = False, left: bool = False) -> None:
        """Say which drive wheels somebody holds; told to turn, they draw too much current."""
        for wheel, held in ((self._wheels.right, right), (self._wheels.left, left)):
            wheel.held = held
            wheel.speed = 0.0 if held else wheel.speed
        self._sensed = None

    def plug_charger(self, plugged: bool) -> None:
        """Plug in or pull the internal charger, powered."""
        self._electrics.charger = plugged
        self._sensed = None

    def power_home_base(self, powered: bool) -> None:
        """Plug in or pull the mains of all Home Bases: their beams and contacts.  Starts on."""
        self._electrics.base_powered = powered
        self._sensed = None

    def set_battery(self, *, charge: float | None = None, temperature: float | None = None,
                    fault: bool | None = None) -> None:
        """Set the charge (fraction of capacity), the temperature (deg C), the charger's fault."""
        battery = self._electrics.battery
        if charge is not None:
            battery.charge = _fraction(charge) * battery.config.capacity
        if temperature is not None:
            _finite('a temperature', temperature)
            battery.temperature = temperature
        if fault is not None:
            battery.fault = fault
        self._sensed = None

    def load(self, *, ld0: float = 0.0, ld1: float = 0.0, ld2: float = 0.0) -> None:
        """Say what hangs on the low side drivers: amperes each would draw when fully on."""
        _finite('a load', ld0, ld1, ld2)
        self._electrics.loads = (ld0, ld1, ld2)
        self._sensed = None

    # Time.

    def _piece(self, longest: float) -> float:
        """Let pass the longest time in which nothing changes its nature; return its seconds."""
        h = min(longest, self._deadline - self._time)
        if h > _MOMENT or h == longest:
            wheels = self._wheels
            if self._push_end < math.inf:
                h = min(h, _LONGEST_PIECE)
                self._move(wheels.roll(h, self._pose.yaw, *self._push))
            elif not wheels.at_rest:
                h = wheels.horizon(min(h, _LONGEST_PIECE))
                self._move(wheels.advance(h, self._pose.yaw))
            else:
                self._lost = 0.0
            self._electrics.step(h, self._drawn())
            self._time += h
            self._sensed = None
        if self._time >= self._deadline - _MOMENT:
            self._expire()
        return max(h, 0.0)

    def _set_deadline(self) -> None:
        self._deadline = min(self._push_end, self._slip_end, self._overlay.deadline)

    def _expire(self) -> None:
        """End what was to last until now."""
        now = self._time + _MOMENT
        if self._push_end <= now:
            self._push_end = math.inf
            self._wheels.let_go()
        if self._slip_end <= now:
            self._slip_end = math.inf
            self._wheels.right.slip = self.config.right_slip
            self._wheels.left.slip = self.config.left_slip
        self._overlay.expire(now)
        self._set_deadline()
        self._sensed = None

    # Physics.

    def _move(self, motion: Motion) -> None:
        """Take the motion as far as obstacles allow, and count it."""
        x, y, yaw = self._pose
        travel, right, left = motion.travel, motion.right, motion.left
        place = (x + motion.dx, y + motion.dy)
        self._lost = 0.0
        if motion.travel:
            self._surroundings.move_to(*place)
            free = (self._surroundings.push_out(*place, (x, y))
                    if self._surroundings.obstacles and not self._lifted else None)
            if free is not None:
                heading = yaw + motion.turn / 2
                travel = (free[0] - x) * math.cos(heading) + (free[1] - y) * math.sin(heading)
                right, left = self._yield(1 - travel / motion.travel, right, left)
                place = free
        self._pose = Pose(*place, math.remainder(yaw + motion.turn, math.tau))
        self._travelled += travel
        self._turned += motion.turn
        self._count(self._wheels.right.count(right), self._wheels.left.count(left))
        self._stand()

    def _yield(self, lost: float, right: float, left: float) -> tuple[float, float]:
        """Note that an obstacle took part of the way; return what the treads then travel."""
        self._lost = lost = _fraction(lost)
        if self.config.contact is Contact.SLIP:
            return right, left
        self._wheels.stall(lost)
        common = (right + left) / 2 * lost
        return right - common, left - common

    def _count(self, right: float, left: float) -> None:
        """Add what the encoders counted, metres, to what packets 19 and 20 will say."""
        if right or left:
            self._distance.add(500 * (right + left))
            self._angle.add(math.degrees((right - left) / self.config.encoder_separation))

    def _stand(self) -> None:
        """Work out which wheels have floor below them and whether the robot is docked."""
        self._sensed = None
        config, pose, up = self.config, self._pose, not self._lifted
        right, left, caster = self._dropped
        self._wheels.right.grounded = up and not right and self._floor(0, -config.wheel_lateral)
        self._wheels.left.grounded = up and not left and self._floor(0, config.wheel_lateral)
        self._caster_grounded = up and not caster and self._floor(config.caster_forward, 0)
        self._electrics.docked = up and surroundings.docked(self.world, pose, config.body_radius)

    def _floor(self, forward: float, left: float) -> bool:
        """Return whether there is floor at a point of the robot."""
        near = self._surroundings
        return near.firm or near.floor(self._pose.ahead(forward, left)) is not None

    def _overloaded(self, wheel: Wheel) -> bool:
        """Return whether a wheel is told to turn and cannot."""
        stalls = self.config.contact is Contact.STALL and self._lost > _BLOCKED
        return wheel.target != 0 and (wheel.held or stalls)

    def _drawn(self) -> float:
        """Return what the wheels' motors draw, amperes."""
        config, drawn = self.config.battery, 0.0
        for wheel in (self._wheels.right, self._wheels.left):
            if self._overloaded(wheel):
                drawn += config.wheel_stalled
            elif wheel.target and self._lost > _BLOCKED:
                drawn += config.wheel_blocked
            elif wheel.target or wheel.speed:
                drawn += config.wheel_idle + config.wheel_per_speed * abs(wheel.speed)
        return drawn

    # Sensors.

    def _look(self) -> Readings:
        """Work out what the physics says."""
        electrics, battery = self._electrics, self._electrics.battery
        bumps, wall, floors = self._feel()
        signals = self._noisy(floors)
        virtual_wall, infrared = surroundings.beams(self.world, self._pose,
                                                    electrics.base_powered)
        overloads = electrics.overloads()
        right, left = self._wheels.right, self._wheels.left
        return Readings(
            bump_left=bumps[0], bump_right=bumps[1], drop_left=not left.grounded,
            drop_right=not right.grounded, drop_caster=not self._caster_grounded,
            wall=wall >= surroundings.WALL_SEEN, wall_signal=wall,
            cliff_left=floors[0] < surroundings.CLIFF_BELOW,
            cliff_front_left=floors[1] < surroundings.CLIFF_BELOW,
            cliff_front_right=floors[2] < surroundings.CLIFF_BELOW,
            cliff_right=floors[3] < surroundings.CLIFF_BELOW,
            cliff_left_signal=signals[0], cliff_front_left_signal=signals[1],
            cliff_front_right_signal=signals[2], cliff_right_signal=signals[3],
            virtual_wall=virtual_wall, infrared=infrared,
            overcurrent_left_wheel=self._overloaded(left),
            overcurrent_right_wheel=self._overloaded(right), overcurrent_ld0=overloads[0],
            overcurrent_ld1=overloads[1], overcurrent_ld2=overloads[2],
            charging_state=battery.state, voltage=clamped('voltage', 1000 * battery.voltage),
            current=clamped('current', 1000 * battery.current),
            temperature=clamped('temperature', battery.temperature),
            charge=clamped('charge', 1000 * battery.charge),
            capacity=clamped('capacity', 1000 * battery.config.capacity),
            home_base=electrics.home_base, internal_charger=electrics.charger)

    def _feel(self) -> tuple[tuple[bool, bool], int, tuple[int, ...]]:
        """Return bumps left and right, the wall sensor's signal, the cliff sensors' four."""
        if self._lifted:
            return (False, False), 0, (0, 0, 0, 0)
        pose, near = self._pose, self._surroundings
        floors = near.cliff_signals(pose)
        if not near.obstacles:
            return (False, False), 0, floors
        return near.bumps(pose), near.wall_signal(pose), floors

    def _noisy(self, floors: tuple[int, ...]) -> tuple[int, ...]:
        """Return the floor's signals as read: up to 15 more or less, never below 0."""
        bits = self._random.getrandbits(20)
        return tuple(max(0, signal + (bits >> 5 * place & 31) - 16)
                     for place, signal in enumerate(floors))


def _fraction(value: float) -> float:
    return min(1.0, max(0.0, value))


def _finite(what: str, *values: float) -> None:
    for value in values:
        if not math.isfinite(value):
            raise ValueError(f'{what} of {value}: finite numbers are wanted')


def _after(now: float, seconds: float) -> float:
    if not seconds >= 0:
        raise ValueError(f'{seconds} seconds: 0 or more are wanted')
    return now + seconds
