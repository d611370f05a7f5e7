# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""From what the body senses to the values of the packets, replies and stream frames."""

from collections.abc import Callable
from enum import IntFlag
from operator import attrgetter, mul

from ... import oi
from ...oi import (
    BumpsAndWheelDrops,
    Buttons,
    ChargingSources,
    DigitalInputs,
    Overcurrents,
    PacketList,
)
from ..body import Body
from ..body.sensed import PACKET_NAMES, Sensed


def _flags(places: dict[str, IntFlag]) -> Callable[[Sensed], int]:
    """Return a function that packs sensors into one byte; called often, so mostly in C."""
    get, weights = attrgetter(*places), tuple(map(int, places.values()))
    return lambda sensed: sum(map(mul, get(sensed), weights))


_bumps_and_wheel_drops = _flags({
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


FIELDS = {PACKET_NAMES.get(field, field): field for field in Sensed._fields
          if PACKET_NAMES.get(field, field) in oi.NUMBERS}
"""Fields of the body's sensors that are a packet of their own, by the packet's name."""
_of_fields = attrgetter(*FIELDS.values())


def packet_values(sensed: Sensed) -> dict[str, int]:
    """Return the values that the body gives by packet name, except 19 and 20."""
    return {
        **dict(zip(FIELDS, _of_fields(sensed))),
        'bumps_and_wheel_drops': _bumps_and_wheel_drops(sensed),
        'overcurrents': _overcurrents(sensed), 'unused_15': 0, 'unused_16': 0,
        'buttons': _buttons(sensed), 'digital_inputs': _digital_inputs(sensed),
        'charging_sources': _charging_sources(sensed),
    }


class Telemetry:
    """Replies to input commands, and the frames of the stream."""

    def __init__(self, body: Body, checksum: oi.Checksum) -> None:
        self._body = body
        self._header_in_sum = checksum is oi.Checksum.HARDWARE
        self._take = {'distance': body.take_distance, 'angle': body.take_angle}
        self.frames = 0
        """Frames made so far."""
        self.reset()

    def reset(self) -> None:
        self.streaming = False
        """Whether a frame is sent in every slot."""
        self._list = PacketList(())
        self._known: dict[str, int] | None = None
        """Values of packets, but distance and angle, in this slot."""

    def refresh(self) -> None:
        """Read the sensors again; values change every 15 ms (manual: Input Commands)."""
        self._known = None

    def answer(self, command: oi.Command, own: dict[str, int]) -> bytes:
        """Return the reply to an input command; `own` has the packets not from the body."""
        match command:
            case oi.Sensors(packet=packet):
                return self._reply((packet,), own)
            case oi.QueryList(packets=packets):
                return self._reply(packets, own)
            case oi.Stream(packets=packets):
                self._list = PacketList(packets)
                self.streaming = bool(packets)
            case oi.PauseResumeStream(state=state):
                self.streaming = state == oi.StreamState.RESUME and bool(self._list.ids)
        return b''

    def _reply(self, ids: tuple[int, ...], own: dict[str, int]) -> bytes:
        packets = PacketList(ids)
        return packets.pack_reply(self._values(packets, own))

    def frame(self, own: dict[str, int]) -> bytes:
        """Return the next frame of the stream; values only, if it is too long for a frame."""
        self.frames += 1
        values = self._values(self._list, own)
        if self._list.frame_size > oi.FRAME_LIMIT:
            # Groups can add up to more than the length byte can hold, and more than any baud rate
            # carries in a slot (manual: Stream, 'will eventually become corrupted').
            return self._list.pack_reply(values)
        return self._list.pack_frame(values, header_in_sum=self._header_in_sum)

    def _values(self, packets: PacketList, own: dict[str, int]) -> list[int]:
        """Return values in the order of a list; reading distance and angle resets them."""
        if self._known is None:
            self._known = packet_values(self._body.sense())
        known, take = self._known, self._take
        known.update(own, stream_packets=len(self._list.ids))
        return [take[name]() if name in take else known[name] for name in packets.names]
