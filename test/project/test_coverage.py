# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The coverage floors: every measured room has one, and the table judges it."""

from runpy import run_path
import tomllib
from typing import Any

import pytest

from support.source import ROOT

TOOL: Any = run_path(str(ROOT / 'tools' / 'coverage_floors.py'))
SETTINGS = tomllib.loads((ROOT / 'pyproject.toml').read_text('utf-8'))


def test_every_measured_room_has_a_floor() -> None:
    floors = TOOL['floors']()
    assert list(floors) == SETTINGS['tool']['coverage']['run']['source']
    assert all((ROOT / name).is_dir() and 0 < floor <= 100 for name, floor in floors.items())


def test_the_protocol_is_covered_completely() -> None:
    assert TOOL['floors']()['create_oi_ros/oi'] == 100


@pytest.mark.parametrize(('covered', 'floor', 'verdict'), [
    (99.99, 100, 'too low'), (100.0, 100, ''), (98.75, 98.7, ''),
    (98.8, 98.7, 'raise the floor to 98.8'), (98.89, 98, 'raise the floor to 98.8')])
def test_a_room_is_judged_by_its_floor(covered: float, floor: float, verdict: str) -> None:
    room = TOOL['Room']('create_oi_ros/oi', covered, floor, '')
    assert room.verdict == verdict
    assert TOOL['table']([room]).splitlines()[1].endswith(verdict or f' {floor:g}')
