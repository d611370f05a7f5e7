"""From what the body senses to the values of the packets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntFlag
from functools import lru_cache
from operator import attrgetter, mul

from create_oi_ros.oi import (
    BumpsAndWheelDrops,
    Buttons,
    ChargingSources,
    DigitalInputs,
    Overcurrents,
    PacketList,
)
from create_oi_ros.sim.readings import Readings


def _flags(places: dict[str, IntFlag]) -> Callable[[Readings], int]:
    """Return a function that gathers sensors into one byte; mostly in C, for it runs often."""
    get, weights = attrgetter(*places), tuple(map(int, places.values()))
    return lambda readings: sum(map(mul, get(readings), weights))


bumps_and_wheel_drops = _flags({
    'bump_right': BumpsAndWheelDrops.BUMP_RIGHT,
    'bump_left': BumpsAndWheelDrops.BUMP_LEFT,
    'drop_right': BumpsAndWheelDrops.WHEEL_DROP_RIGHT,
    'drop_left': BumpsAndWheelDrops.WHEEL_DROP_LEFT,
    'drop_caster': BumpsAndWheelDrops.WHEEL_DROP_CASTER,
})
_overcurrents = _flags({
    'overcurrent_ld1': Overcurrents.DRIVER_1,
    'overcurrent_ld0': Overcurrents.DRIVER_0,
    'overcurrent_ld2': Overcurrents.DRIVER_2,
    'overcurrent_right_wheel': Overcurrents.RIGHT_WHEEL,
    'overcurrent_left_wheel': Overcurrents.LEFT_WHEEL,
})
_buttons = _flags({'play': Buttons.PLAY, 'advance': Buttons.ADVANCE})
_digital_inputs = _flags({
    'digital_input_0': DigitalInputs.INPUT_0,
    'digital_input_1': DigitalInputs.INPUT_1,
    'digital_input_2': DigitalInputs.INPUT_2,
    'digital_input_3': DigitalInputs.INPUT_3,
    'device_detect': DigitalInputs.BAUD_RATE_CHANGE,
})
_charging_sources = _flags({
    'internal_charger': ChargingSources.INTERNAL_CHARGER,
    'home_base': ChargingSources.HOME_BASE,
})


def sensed(readings: Readings) -> dict[str, int]:
    """Return the values that come from the body, by the packets' names, but 19 and 20."""
    r = readings
    return {
        'bumps_and_wheel_drops': bumps_and_wheel_drops(r),
        'wall': r.wall,
        'cliff_left': r.cliff_left,
        'cliff_front_left': r.cliff_front_left,
        'cliff_front_right': r.cliff_front_right,
        'cliff_right': r.cliff_right,
        'virtual_wall': r.virtual_wall,
        'overcurrents': _overcurrents(r),
        'unused_15': 0,
        'unused_16': 0,
        'infrared': r.infrared,
        'buttons': _buttons(r),
        'charging_state': r.charging_state,
        'voltage': r.voltage,
        'current': r.current,
        'battery_temperature': r.temperature,
        'battery_charge': r.charge,
        'battery_capacity': r.capacity,
        'wall_signal': r.wall_signal,
        'cliff_left_signal': r.cliff_left_signal,
        'cliff_front_left_signal': r.cliff_front_left_signal,
        'cliff_front_right_signal': r.cliff_front_right_signal,
        'cliff_right_signal': r.cliff_right_signal,
        'digital_inputs': _digital_inputs(r),
        'analog_signal': r.analog,
        'charging_sources': _charging_sources(r),
    }


@lru_cache(maxsize=256)
def packet_list(ids: tuple[int, ...]) -> PacketList:
    """Compile a list; a host that polls asks for the same ones over and over."""
    return PacketList(ids)


def pack_frame(packets: PacketList, values: Sequence[int], *, header_in_sum: bool) -> bytes:
    """Encode a stream frame, even one that is too long to have a length."""
    if packets.length > 0xff:
        # Groups in a list can ask for more than a length byte can say, and than any baud rate
        # carries in a slot (manual: Stream, 'will eventually become corrupted').
        return packets.pack_reply(values)
    return packets.pack_frame(values, header_in_sum=header_in_sum)
