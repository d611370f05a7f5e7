# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The control socket, faults and record of `create_sim`, and the pages that name them."""

import csv
from dataclasses import fields
from enum import Enum
import os
from pathlib import Path
import threading

import pytest

from create_oi_ros.sim.firmware.guesses import DEFAULT_GUESSES, Guesses
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
