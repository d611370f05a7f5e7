# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The wait commands: each becomes a function that is called in every slot until it is true."""

from collections.abc import Callable
import math

from ... import oi
from ...oi import Event
from ...robot import SLOT
from ..body import Body
from ..body.sensed import Sensed

Over = Callable[[], bool]
"""Whether a wait is over."""
REACHED = 1e-6
"""Millimetres or degrees by which a sum of floats may fall short of the value it stands for."""

SENSORS: dict[Event, tuple[str, ...]] = {
    Event.WHEEL_DROP: ('drop_caster', 'drop_left', 'drop_right'),
    Event.FRONT_WHEEL_DROP: ('drop_caster',),
    Event.LEFT_WHEEL_DROP: ('drop_left',),
    Event.RIGHT_WHEEL_DROP: ('drop_right',),
    Event.BUMP: ('bump_left', 'bump_right'),
    Event.LEFT_BUMP: ('bump_left',),
    Event.RIGHT_BUMP: ('bump_right',),
    Event.VIRTUAL_WALL: ('virtual_wall',),
    Event.WALL: ('wall',),
    Event.CLIFF: ('cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right'),
    Event.LEFT_CLIFF: ('cliff_left',),
    Event.FRONT_LEFT_CLIFF: ('cliff_front_left',),
    Event.FRONT_RIGHT_CLIFF: ('cliff_front_right',),
    Event.RIGHT_CLIFF: ('cliff_right',),
    Event.HOME_BASE: ('home_base',),
    Event.ADVANCE_BUTTON: ('advance',),
    Event.PLAY_BUTTON: ('play',),
    Event.DIGITAL_INPUT_0: ('digital_input_0',),
    Event.DIGITAL_INPUT_1: ('digital_input_1',),
    Event.DIGITAL_INPUT_2: ('digital_input_2',),
    Event.DIGITAL_INPUT_3: ('digital_input_3',),
}


def cliff(sensed: Sensed) -> bool:
    """Tell whether any of the four cliff sensors sees a cliff."""
    return (sensed.cliff_left or sensed.cliff_front_left
            or sensed.cliff_front_right or sensed.cliff_right)


def wheel_drop(sensed: Sensed) -> bool:
    """Tell whether any of the three wheels has dropped."""
    return sensed.drop_caster or sensed.drop_left or sensed.drop_right


def waiting(command: oi.Command, body: Body, slots: Callable[[], int],
            passive: Callable[[], bool]) -> Over:
    """Start a wait, in mm or degrees, slots or for an event; return what tells when it is over."""
    match command:
        case oi.WaitTime(time=tenths):
            last = slots() + math.ceil(tenths / 10 / SLOT - REACHED)
            return lambda: slots() >= last
        case oi.WaitDistance(distance=goal):
            body.take_distance()
            start = body.distance_total
            return lambda: _reached(body.distance_total - start, goal)
        case oi.WaitAngle(angle=goal):
            body.take_angle()
            start = body.angle_total
            return lambda: _reached(body.angle_total - start, goal)
        case oi.WaitEvent(event=number):
            event, wanted = Event(abs(number)), number > 0
            if event is Event.OI_MODE_PASSIVE:
                return lambda: passive() is wanted
            return lambda: any(
                getattr(body.sense(), name) for name in SENSORS[event]) is wanted
    raise ValueError(f'{command} is no wait command')


def _reached(value: float, goal: int) -> bool:
    return value >= goal - REACHED if goal >= 0 else value <= goal + REACHED
