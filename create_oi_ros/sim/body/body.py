# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The robot's body: wheels, encoders, bumper, sensors, battery, in a world.

The firmware drives it: `drive` sets wheel speeds, `low_side` duty cycles, `allow_charging`
permits charging. `step(dt)` lets time pass. `sense()`, `take_distance()` and `take_angle()` read
the sensors.

    body = Body(world, rounding=Rounding.TRUNCATE, seed=0)
    body.drive(right=0.2, left=0.2)
    body.step(0.015)
    sensed = body.sense()          # a `Sensed`, cached until something changes
    millimetres = body.take_distance()

A script's wait notes `distance_total` or `angle_total` at its start, resets packet 19 or 20 with
`take_distance` or `take_angle`, and compares the total as time goes on.

A test or the control socket sets what happens around the robot: `force` and `unforce` any sensor
(bumper, buttons, infrared, cliffs, analog and digital inputs), `place`, `push`, `lift`, `drop`,
`hold`, `slip`, `plug_charger`, `power_home_base`, `set_battery`, `load`. `truth` tells what really
happened.

There is no clock: the same calls with the same seed give the same robot. SI units, x forward, yaw
counter-clockwise; only `Sensed` has the manual's units.
"""

import math
from random import Random

from ...robot import MILLI, Rounding
from ..world import Pose, World
from .battery import CAPACITY, Electrics
from .config import BodyConfig, DEFAULT_BODY
from .gyro import Gyro
from .mechanics import Mechanics, Truth
from .sensed import clamped, ForcedValues, Sensed
from .surroundings import CLIFF_BELOW, WALL_SEEN
from .wheels import TIME_TOLERANCE

LONGEST_STEP = 1.0
"""Seconds that are computed at once: so long, the battery hardly changes."""


class Body:
    """A Create's mechanics, sensors and battery."""

    def __init__(self, world: World, *, rounding: Rounding = Rounding.TRUNCATE, seed: int = 0,
                 config: BodyConfig = DEFAULT_BODY) -> None:
        self.config = config
        self.world = world
        self._time, self._deadline = 0.0, math.inf
        self._mechanics = Mechanics(world, config, rounding, seed)
        self._electrics = Electrics()
        self._forced = ForcedValues()
        self._sensed: Sensed | None = None
        self._random = Random(seed)
        self._gyro = Gyro(seed) if config.gyro else None
        self._push_end = self._slip_end = math.inf
        self.place(world.start)

    # Commands of the firmware.

    def drive(self, *, right: float, left: float) -> None:
        """Set the target wheel speeds, m/s, clamped to the wheels' maximum."""
        self._mechanics.wheels.right.command(right)
        self._mechanics.wheels.left.command(left)
        self._sensed = None

    def low_side(self, *, duty0: float, duty1: float, duty2: float) -> None:
        """Set the low side drivers' duty cycles, clamped to 0 to 1."""
        self._electrics.duties = tuple(map(_fraction, (duty0, duty1, duty2)))
        self._sensed = None

    def allow_charging(self, allowed: bool) -> None:
        """Permit charging or forbid it; the firmware permits it in Off and Passive only."""
        self._electrics.charging_allowed = allowed

    def power(self, on: bool) -> None:
        """Switch the electronics, which draw a current; a charger works either way."""
        self._electrics.on = on

    def step(self, dt: float) -> None:
        """Let dt seconds pass, computed in steps as small as the physics needs."""
        if not 0 <= dt < math.inf:
            raise ValueError(f'dt is {dt}; allowed: finite seconds, 0 or more')
        while dt > 0:
            dt -= self._step(dt)

    # What the firmware reads.

    def sense(self) -> Sensed:
        """Return all sensors as they are now, forced values included; cached until a change."""
        if self._sensed is None:
            self._sensed = self._forced.put_over(self._read_sensors())
        return self._sensed

    def take_distance(self) -> int:
        """Packet 19: millimetres since the last call, -32768 to 32767; the call resets it."""
        return self._mechanics.distance.take()

    def take_angle(self) -> int:
        """Packet 20: degrees counter-clockwise since the last call; the call resets it."""
        return self._mechanics.angle.take()

    @property
    def distance_total(self) -> float:
        """Millimetres by the encoders since the start, signed, unrounded; never reset."""
        return self._mechanics.distance.total

    @property
    def angle_total(self) -> float:
        """Degrees by the encoders since the start, signed, unrounded; never reset."""
        return self._mechanics.angle.total

    @property
    def battery_flat(self) -> bool:
        """Whether no charge is left; a real robot is then off."""
        return self._electrics.battery.charge <= 0

    # What somebody outside does.

    def truth(self) -> Truth:
        return self._mechanics.truth()

    def force(self, *, seconds: float = math.inf, **values: int) -> None:
        """
        Hold sensors of `Sensed` at values, for some seconds or until `unforce`.

        Examples: force(bump_left=True), force(seconds=0.2, play=True), force(infrared=130).
        ValueError names an unknown field or a value out of range; nothing is held then.
        """
        self._forced.force(values, _end_of(self._time, seconds))
        self._set_deadline()
        self._sensed = None

    def unforce(self, *names: str) -> None:
        """Give the named sensors back to the physics; without names, all."""
        self._forced.release(names)
        self._set_deadline()
        self._sensed = None

    def place(self, pose: Pose) -> None:
        """Put the robot elsewhere without turning its wheels; obstacles push it out."""
        _finite('pose', *pose)
        self._mechanics.place(pose)
        self._electrics.docked = self._mechanics.docked
        self._sensed = None

    def push(self, *, speed: float, rate: float, seconds: float) -> None:
        """Roll the robot by hand at m/s and rad/s for some seconds; its wheels turn too."""
        _finite('push', speed, rate, seconds)
        self._push_end = _end_of(self._time, seconds)
        self._mechanics.pushed = (speed, rate)
        self._set_deadline()

    def slip(self, *, right: float, left: float, seconds: float) -> None:
        """Let the wheels lose these parts, 0 to 1, of their travel for some seconds."""
        _finite('slip', right, left, seconds)
        self._slip_end = _end_of(self._time, seconds)
        wheels = self._mechanics.wheels
        wheels.right.slip, wheels.left.slip = _fraction(right), _fraction(left)
        self._set_deadline()

    def lift(self, lifted: bool) -> None:
        """Lift the robot or put it down; lifted, all wheels drop and no floor is seen."""
        self._mechanics.lifted = lifted
        self.place(self._mechanics.pose)

    def drop(self, *, right: bool = False, left: bool = False, caster: bool = False) -> None:
        """Set which wheels hang down; a drive wheel that hangs down has no grip."""
        self._mechanics.dropped = (right, left, caster)
        self._mechanics.update_support()
        self._sensed = None

    def hold(self, *, right: bool = False, left: bool = False) -> None:
        """Set which drive wheels somebody holds; if commanded, they draw too much current."""
        wheels = self._mechanics.wheels
        for wheel, held in ((wheels.right, right), (wheels.left, left)):
            wheel.hold(held)
        self._sensed = None

    def plug_charger(self, plugged: bool) -> None:
        self._electrics.charger = plugged
        self._sensed = None

    def power_home_base(self, powered: bool) -> None:
        """Switch all Home Bases, beams and contacts, on or off; they start on."""
        self._electrics.base_powered = powered
        self._sensed = None

    def set_battery(self, *, charge: float | None = None, temperature: float | None = None,
                    fault: bool | None = None, waits: bool | None = None) -> None:
        """Set charge (fraction of capacity), temperature (deg C); make a charger fail, or wait."""
        battery = self._electrics.battery
        if charge is not None:
            battery.charge = _fraction(charge) * CAPACITY
        if temperature is not None:
            _finite('temperature', temperature)
            battery.temperature = temperature
        if fault is not None:
            battery.fault = fault
        if waits is not None:
            battery.waits = waits
        self._sensed = None

    def load(self, *, ld0: float = 0.0, ld1: float = 0.0, ld2: float = 0.0) -> None:
        """Set the loads of the low side drivers: amperes that each draws when fully on."""
        _finite('load', ld0, ld1, ld2)
        self._electrics.loads = tuple(max(0.0, each) for each in (ld0, ld1, ld2))
        self._sensed = None

    # Time.

    def _step(self, longest: float) -> float:
        """Advance by the longest time with constant accelerations and no deadline; return it."""
        h = min(longest, self._deadline - self._time, LONGEST_STEP)
        if h > TIME_TOLERANCE or h == longest:
            mechanics = self._mechanics
            h = mechanics.horizon(h)
            mechanics.advance(h)
            self._electrics.docked = mechanics.docked
            self._electrics.step(h, mechanics.drawn())
            self._time += h
            self._sensed = None
        if self._time >= self._deadline - TIME_TOLERANCE:
            self._expire()
        return h if h > 0 else 0.0

    def _set_deadline(self) -> None:
        self._deadline = min(self._push_end, self._slip_end, self._forced.deadline)

    def _expire(self) -> None:
        """End the pushes, slips and forced values whose time is over."""
        now = self._time + TIME_TOLERANCE
        if self._push_end <= now:
            self._push_end = math.inf
            self._mechanics.pushed = None
            self._mechanics.wheels.let_go()
        if self._slip_end <= now:
            self._slip_end = math.inf
            self._mechanics.wheels.right.slip = self.config.right_slip
            self._mechanics.wheels.left.slip = self.config.left_slip
        self._forced.expire(now)
        self._set_deadline()
        self._sensed = None

    # Sensors.

    def _read_sensors(self) -> Sensed:
        """Return the sensors as the physics has them."""
        mechanics, electrics, battery = self._mechanics, self._electrics, self._electrics.battery
        bumps, wall, floors = mechanics.contacts_and_floor()
        signals = self._noisy(floors)
        virtual_wall, infrared = mechanics.surroundings.beams(
            mechanics.pose, electrics.base_powered)
        overloads = electrics.overloads
        right, left = mechanics.wheels.right, mechanics.wheels.left
        analog = 0 if self._gyro is None else self._gyro.read(mechanics.truth().rate, self._time)
        return Sensed(
            bump_left=bumps[0], bump_right=bumps[1], drop_left=not left.grounded,
            drop_right=not right.grounded, drop_caster=not mechanics.caster_grounded,
            wall=wall >= WALL_SEEN, wall_signal=wall,
            cliff_left=floors[0] < CLIFF_BELOW,
            cliff_front_left=floors[1] < CLIFF_BELOW,
            cliff_front_right=floors[2] < CLIFF_BELOW,
            cliff_right=floors[3] < CLIFF_BELOW,
            cliff_left_signal=signals[0], cliff_front_left_signal=signals[1],
            cliff_front_right_signal=signals[2], cliff_right_signal=signals[3],
            virtual_wall=virtual_wall, infrared=infrared,
            overcurrent_left_wheel=mechanics.overloaded(left),
            overcurrent_right_wheel=mechanics.overloaded(right), overcurrent_ld0=overloads[0],
            overcurrent_ld1=overloads[1], overcurrent_ld2=overloads[2],
            charging_state=battery.state, voltage=clamped('voltage', battery.voltage / MILLI),
            current=clamped('current', battery.current / MILLI),
            temperature=clamped('temperature', battery.temperature),
            charge=clamped('charge', battery.charge / MILLI),
            capacity=clamped('capacity', CAPACITY / MILLI),
            home_base=electrics.home_base, internal_charger=electrics.charger, analog=analog)

    def _noisy(self, floors: tuple[int, ...]) -> list[int]:
        """Return the floor signals with noise: up to 16 less or 15 more, never below 0."""
        bits = self._random.getrandbits(20)
        noisy = [signal + (bits >> 5 * place & 31) - 16 for place, signal in enumerate(floors)]
        return [signal if signal > 0 else 0 for signal in noisy]


def _fraction(value: float) -> float:
    return min(1.0, max(0.0, value))


def _finite(what: str, *values: float) -> None:
    for value in values:
        if not math.isfinite(value):
            raise ValueError(f'{what} of {value}; allowed: finite numbers')


def _end_of(now: float, seconds: float) -> float:
    if not seconds >= 0:
        raise ValueError(f'{seconds} seconds; allowed: 0 or more')
    return now + seconds
