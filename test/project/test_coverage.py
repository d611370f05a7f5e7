# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The coverage floors: every measured room has one, and the table judges it."""

from runpy import run_path
from typing import Any

import pytest

from support.source import ROOT

TOOL: Any = run_path(str(ROOT / 'tools' / 'coverage_floors.py'))


def test_every_room_has_a_floor_and_so_has_the_whole_package() -> None:
    floors = TOOL['floors']()
    rooms = [f'create_oi_ros/{path.name}' for path in (ROOT / 'create_oi_ros').iterdir()
             if (path / '__init__.py').exists()]
    assert sorted(floors) == sorted([*rooms, 'create_oi_ros'])
    assert all(0 < floor <= 100 for floor in floors.values())


def test_the_protocol_is_covered_completely() -> None:
    assert TOOL['floors']()['create_oi_ros/oi'] == 100


@pytest.mark.parametrize(('covered', 'floor', 'verdict'), [
    (99.99, 100, 'too low'), (100.0, 100, ''), (98.75, 98.7, ''),
    (98.8, 98.7, 'raise the floor to 98.8'), (98.89, 98, 'raise the floor to 98.8')])
def test_a_room_is_judged_by_its_floor(covered: float, floor: float, verdict: str) -> None:
    room = TOOL['Room']('create_oi_ros/oi', covered, floor, '')
    assert room.verdict == verdict
    assert TOOL['table']([room]).splitlines()[1].endswith(verdict or f' {floor:g}')
