"""
The topics that follow the robot's readings, declared once: what, when, how.

Publishers, their documentation and the decision what is due derive from this table.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from builtin_interfaces.msg import Time
from create_oi_msgs.msg import Bumper, Cliff, WheelDrop
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

from . import convert
from .oi import BumpsAndWheelDrops, Readings

BUMPS = BumpsAndWheelDrops.BUMP_LEFT | BumpsAndWheelDrops.BUMP_RIGHT
DROPS = ~BUMPS


@dataclass(frozen=True)
class SensorTopic:
    """One topic made of readings."""

    name: str
    type: type
    needs: tuple[str, ...]
    """Readings that must have arrived."""
    watch: Callable[[Readings], object]
    """What is published at once when it changes."""
    convert: Callable[..., Any]
    """Makes the message of readings and a header."""
    period: float | None = None
    """Seconds after which it is published though nothing changed; None: at `sensor_rate`."""
    about: str = ''


CLIFFS = ('cliff_left', 'cliff_front_left', 'cliff_front_right', 'cliff_right')
SENSOR_TOPICS: tuple[SensorTopic, ...] = (
    SensorTopic(
        'bumper', Bumper, ('bumps_and_wheel_drops',),
        lambda readings: readings.bumps_and_wheel_drops & BUMPS, convert.bumper,
        about='the two halves of the bumper'),
    SensorTopic(
        'wheel_drop', WheelDrop, ('bumps_and_wheel_drops',),
        lambda readings: readings.bumps_and_wheel_drops & DROPS, convert.wheel_drop,
        about='wheels and caster that hang in the air'),
    SensorTopic(
        'cliff', Cliff, (*CLIFFS, *(f'{name}_signal' for name in CLIFFS)),
        lambda readings: [getattr(readings, name) for name in CLIFFS], convert.cliff,
        about='the four cliff sensors, with signal strengths'),
    SensorTopic(
        'battery_state', BatteryState,
        ('charging_state', 'voltage', 'current', 'battery_temperature', 'battery_charge',
         'battery_capacity', 'charging_sources'),
        lambda readings: (readings.charging_state, readings.charging_sources),
        convert.battery_state, period=1.0,
        about='voltage, current, charge and temperature'),
)


class Edge:
    """Tells when a topic is due: at once on change, else after its period."""

    def __init__(self, topic: SensorTopic) -> None:
        self._topic = topic
        self._last: object = None
        self._last_at = -float('inf')

    def due(self, readings: Readings, stamp: float, sensor_period: float) -> bool:
        """Take the newest readings in, of a frame at `stamp` seconds."""
        if not readings.has(*self._topic.needs):
            return False
        value = self._topic.watch(readings)
        period = self._topic.period or sensor_period
        # Frames come in slots: half a slot early is the slot that is meant.
        if value == self._last and stamp - self._last_at < period - 0.0075:
            return False
        self._last, self._last_at = value, stamp
        return True


def sensor_topics(*, charge_known: bool) -> list[SensorTopic]:
    """Return the table for a battery whose charge the robot can tell, or cannot."""
    return [
        replace(topic, convert=partial(topic.convert, charge_known=charge_known))
        if topic.type is BatteryState else topic for topic in SENSOR_TOPICS]


def header(frame: str, stamp: Time) -> Header:
    """Return a header."""
    return Header(frame_id=frame, stamp=stamp)
