# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The control socket, faults and record of `create_sim`, their page, and the pace of bytes."""

from collections import Counter
import csv
from dataclasses import fields
from enum import Enum
import os
from pathlib import Path
import threading

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros.sim.firmware.guesses import DEFAULT_GUESSES, Guesses
from create_oi_ros.sim.server.faults import Fault, FaultKind, Faults, MOST_GARBAGE
from create_oi_ros.sim.server.serve import Pacer
from support.simulator import (
    ControlClient,
    FRAME,
    FULL,
    opened,
    receive,
    SAFE,
    silent,
    simulator,
    START,
    STREAM,
    taught,
)

Robot = tuple[Path, ControlClient]

# The control socket.

def test_it_sets_the_world_and_waits_for_what_happens(robot: Robot) -> None:
    port, teacher = robot
    with opened(port) as client:
        os.write(client, START + SAFE)
        teacher.tell('wait mode=SAFE')
        os.write(client, bytes([142, 7]))
        assert receive(client, 1) == b'\x00'
        teacher.tell('bump left', 'wait bump_left=1')
        os.write(client, bytes([142, 7]))
        assert receive(client, 1) == b'\x02'
        teacher.tell('bump off', 'lift', 'wait mode=PASSIVE drop_left=true', 'down')
        teacher.tell('charger on', 'wait charging_state=2', 'charger off')
        teacher.tell('place 1 0.5 90')
        pose = teacher.truth()
        assert (pose['x'], pose['y']) == (1.0, 0.5)
        assert pose['yaw'] == pytest.approx(1.5708, abs=1e-4)


def test_every_word_is_understood_or_refused_with_the_reason(robot: Robot) -> None:
    _, teacher = robot
    teacher.tell(
        'help', 'truth', 'sense', 'room', 'wait time>=0 mode=OFF demo=none', 'after 0',
        'bump both 0.1', 'button play 0.1', 'force wall=1 seconds=0.1', 'unforce wall',
        'unforce', 'lift', 'down', 'drop right caster', 'drop', 'hold left', 'hold',
        'push 0.1 0.5 0.2', 'slip 0.1 0.2 1', 'place 0 0 0', 'load ld0=0.3', 'charger off',
        'dock off', 'dock on', 'battery charge=0.5 temperature=20 fault=0 waits=1', 'power off',
        'power on', 'power toggle', 'power toggle', 'power fail', 'cable cut', 'cable mend',
        'fault flip:0.1 cut@100', 'fault off')
    for line in ('', 'dance', 'bump', 'bump up', 'bump left x', 'force nose=1', 'force',
                 'force wall=2', 'force wall=0.5', 'unforce nose', 'place 1 2', 'place 1 2 x',
                 'push 1', 'charger', 'battery charge=x', 'fault burn', 'cable tie', 'wait x',
                 'wait nose=1', 'wait mode>1', 'place nan 0 0', 'after', 'wait x=1 timeout=x',
                 'place 1e200 0 0', 'push 1e300 0 1', 'drop nose', 'load ld9=1', '\xe4\xf6'):
        assert teacher.ask(line).startswith('error '), line
    assert teacher.ask('wait x>9 timeout=0.05').startswith('error timeout')


def test_a_client_that_waits_does_not_block_the_others(robot: Robot) -> None:
    port, teacher = robot
    other = ControlClient(port.parent / 'control')
    answers: list[str] = []
    waiting = threading.Thread(target=lambda: answers.append(other.ask('wait wall=1')))
    waiting.start()
    teacher.tell('truth', 'force wall=1')
    waiting.join()
    assert answers[0].startswith('ok ')
    other.close()


def test_a_cut_cable_loses_all_bytes_and_the_port_stays(robot: Robot) -> None:
    port, teacher = robot
    with opened(port) as client:
        os.write(client, START + STREAM)
        receive(client, FRAME)
        teacher.tell('cable cut')
        os.write(client, SAFE)
        while not silent(client, 0.1):
            os.read(client, 4096)
        assert teacher.truth()['mode'] == 'PASSIVE'
        teacher.tell('cable mend')
        receive(client, FRAME)


def test_a_power_failure_is_answered_by_the_banner(tmp_path: Path) -> None:
    with taught(tmp_path, '--guess', 'boot_seconds=0') as (port, teacher), \
            opened(port) as client:
        os.write(client, START + FULL)
        teacher.tell('wait mode=FULL', 'power fail')
        assert b'RDK by iRobot!' in receive(client, 130)
        assert teacher.truth()['mode'] == 'OFF'


# Faults, record, drawing.

def test_fault_off_ends_all_faults(robot: Robot) -> None:
    port, teacher = robot
    with opened(port) as client:
        teacher.tell('fault silence@0+1000 unplug@1000', 'after 0.05', 'fault off', 'after 0.05')
        os.write(client, START + bytes([142, 35]))
        assert receive(client, 1) == b'\x01'


def test_faults_happen_at_their_times(tmp_path: Path) -> None:
    with taught(tmp_path, '--fault', 'unplug@0.5+0.5', '--fault', 'brownout@2',
                '--speed', '2') as (port, teacher):
        with opened(port) as client:
            os.write(client, START + FULL)
            teacher.tell('wait time>0.6')
            with pytest.raises(OSError, match='Input/output'):
                os.write(client, START)
        teacher.tell('wait time>1.1')
        with opened(port) as client:
            os.write(client, bytes([142, 35]))
            assert receive(client, 1) == b'\x03'
            teacher.tell('wait mode=OFF')


def test_record_writes_the_truth_of_every_slot(tmp_path: Path) -> None:
    port, record = tmp_path / 'create', tmp_path / 'truth.csv'
    with simulator('--link', port, '--record', record) as sim, opened(port) as client:
        os.write(client, START + FULL + STREAM + bytes([145, 0, 200, 0, 200]))
        receive(client, 70 * FRAME)
        assert sim.stop()[0] == 0
    rows = list(csv.DictReader(record.open()))
    times = [float(row['time']) for row in rows]
    assert len(rows) >= 70
    assert all(b - a == pytest.approx(0.015) for a, b in zip(times, times[1:], strict=False))
    assert rows[-1]['mode'] == 'FULL'
    assert float(rows[-1]['x']) > 0.1


# The pages of the simulator.


PAGES = Path(__file__).parents[2] / 'docs'
GUESSES = (PAGES / 'simulator_guesses.md').read_text('utf-8')


@pytest.mark.parametrize('name', [field.name for field in fields(Guesses)])
def test_every_guess_is_there_with_its_default(name: str) -> None:
    value = getattr(DEFAULT_GUESSES, name)
    shown = (str(value).lower() if isinstance(value, bool) else
             value.value if isinstance(value, Enum) else f'{value:g}')
    assert f'`--guess {name}={shown}`' in GUESSES


# Faults that happen on purpose, and bytes that are delayed by the baud rate.


PIECE = bytes(range(100, 150))
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
        data = some.from_robot(PIECE, 0)
        assert data != PIECE
        assert len(data) == len(PIECE) + changed
        if spec == 'flip:1':
            assert sum((a ^ b).bit_count() for a, b in zip(data, PIECE, strict=True)) == 1


def test_garbage_comes_in_front() -> None:
    some = faults('garbage:1')
    sizes = {len(some.from_robot(PIECE, 0)) - len(PIECE) for _ in range(1000)}
    assert sizes == set(range(1, MOST_GARBAGE + 1))
    assert some.from_robot(PIECE, 0).endswith(PIECE)


def test_damage_happens_to_bytes_of_the_robot_except_with_in() -> None:
    assert faults('flip:1').to_robot(PIECE, 0) == PIECE
    assert faults('flip.in:1').to_robot(PIECE, 0) != PIECE
    assert faults('flip.in:1').from_robot(PIECE, 0) == PIECE


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
    assert (some.from_robot(PIECE, 0) == PIECE) is out
    assert (some.to_robot(PIECE, 0) == PIECE) is into


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
