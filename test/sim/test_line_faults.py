# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults that happen on purpose, and bytes that are delayed by the baud rate."""

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.sim.server.faults import Fault, FaultKind, Faults, MOST_GARBAGE
from create_oi_ros.sim.server.serve import Pacer

FRAME = bytes(range(100, 150))
SLOT = 0.015


def faults(*specs: str, seed: int = 1) -> Faults:
    """Return the faults of these specs."""
    return Faults([Fault.parse(spec) for spec in specs], seed)


def going_on(specs: str, kind: FaultKind, seconds: float) -> list[float]:
    """Return the start times of the slots in which a fault lasts."""
    some = faults(specs)
    times = []
    for slot in range(round(seconds / SLOT)):
        some.step(slot * SLOT)
        if some.active(kind):
            times.append(round(slot * SLOT, 3))
    return times


# Damage.

@pytest.mark.parametrize(('spec', 'changed'), [('flip:1', 0), ('drop:1', -1)])
def test_a_rate_of_1_damages_every_frame_once(spec: str, changed: int) -> None:
    some = faults(spec)
    for _ in range(100):
        data = some.from_robot(FRAME, 0)
        assert data != FRAME
        assert len(data) == len(FRAME) + changed
        if spec == 'flip:1':
            assert sum((a ^ b).bit_count() for a, b in zip(data, FRAME, strict=True)) == 1


def test_garbage_comes_in_front() -> None:
    some = faults('garbage:1')
    sizes = {len(some.from_robot(FRAME, 0)) - len(FRAME) for _ in range(1000)}
    assert sizes == set(range(1, MOST_GARBAGE + 1))
    assert some.from_robot(FRAME, 0).endswith(FRAME)


def test_damage_happens_to_bytes_of_the_robot_except_with_in() -> None:
    assert faults('flip:1').to_robot(FRAME, 0) == FRAME
    assert faults('flip.in:1').to_robot(FRAME, 0) != FRAME
    assert faults('flip.in:1').from_robot(FRAME, 0) == FRAME


# Faults that last.

def test_a_time_alone_is_once_for_a_second_a_period_repeats_a_rate_is_times_a_second() -> None:
    times = going_on('silence@1', FaultKind.SILENCE, 5)
    assert (times[0], times[-1]) == (1.005, 1.995)
    times = going_on('cut@1+0.5~2', FaultKind.CUT, 6)
    assert Counter(int(time) for time in times).keys() == {1, 3, 5}
    some = faults('unplug:0.1+0.5')
    begun = sum(FaultKind.UNPLUG in some.step(slot * SLOT) for slot in range(200_000))
    assert 200 < begun < 340


@pytest.mark.parametrize(('kind', 'out', 'into'), [
    ('silence', False, True), ('deaf', True, False), ('cut', False, False),
    ('unplug', False, False), ('brownout', True, True)])
def test_which_way_bytes_are_lost(kind: str, out: bool, into: bool) -> None:
    some = faults(f'{kind}@0')
    assert some.step(0) == {FaultKind(kind)}
    assert (some.from_robot(FRAME, 0) == FRAME) is out
    assert (some.to_robot(FRAME, 0) == FRAME) is into


@pytest.mark.parametrize('spec', ['', 'flip', 'flip@3', 'flip:1.1', 'silence', 'burn:1', 'cut:',
                                  'cut@', 'cut:x', 'flip:-1', 'cut@1+', 'flip:1e3', 'cut@nan'])
def test_a_spec_with_an_error_is_refused(spec: str) -> None:
    with pytest.raises(ValueError, match='allowed|add a rate'):
        Fault.parse(spec)


# Pacing.

def test_a_byte_takes_ten_bits_and_what_is_written_together_arrives_together() -> None:
    pacer = Pacer()
    pacer.put(bytes(10), 0.0, 57600)
    assert pacer.take(9.9 * 10 / 57600) is None
    assert pacer.take(10 * 10 / 57600) == (bytes(10), 57600)
    assert pacer.due() == float('inf')


@given(st.lists(st.tuples(st.binary(max_size=300), st.floats(0, 0.02)), max_size=20),
       st.sampled_from([300, 19200, 57600]))
def test_all_bytes_arrive_in_order_and_none_before_its_time(
        sent: list[tuple[bytes, float]], baud: int) -> None:
    pacer, now, arrived = Pacer(), 0.0, b''

    def take() -> None:
        nonlocal arrived
        while (came := pacer.take(now)) is not None:
            arrived += came[0]
            assert came[1] == baud and len(arrived) <= now * baud / 10 + 1e-3

    for data, seconds in sent:
        pacer.put(data, now, baud)
        now += seconds
        take()
    while pacer.due() < float('inf'):
        now = max(now, pacer.due())
        take()
    assert arrived == b''.join(data for data, _ in sent)
    assert now <= sum(seconds for _, seconds in sent) + len(arrived) * 10 / baud + 0.001
