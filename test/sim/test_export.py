# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Worlds as maps for Nav2, against the worlds' own geometry."""

from math import floor, hypot, inf
from pathlib import Path
from random import Random

import pytest
import yaml

from create_oi_ros.sim.world import shipped, shipped_names, World
from create_oi_ros.sim.world.floor_plan import FREE, Map, map_of, OCCUPIED, RESOLUTION, UNKNOWN
from support.simulator import simulator

REACH = hypot(RESOLUTION, RESOLUTION)
"""Metres by which a cell may differ from what is exactly there."""


def gap(world: World, x: float, y: float) -> float:
    """Return the distance to the nearest obstacle."""
    return min((each.gap(x, y) for each in world.obstacles), default=inf)


def grey_at(drawn: Map, x: float, y: float) -> int:
    """Return the grey value of a place."""
    column = floor((x - drawn.x) / RESOLUTION)
    row = drawn.height - 1 - floor((y - drawn.y) / RESOLUTION)
    inside = 0 <= column < drawn.width and 0 <= row < drawn.height
    return drawn.cells[row * drawn.width + column] if inside else UNKNOWN


@pytest.mark.parametrize('name', shipped_names())
def test_a_map_is_occupied_where_the_world_has_obstacles_and_no_floor(name):
    world, drawn, random = shipped(name), map_of(shipped(name)), Random(1)
    for _ in range(3000):
        x = drawn.x + random.random() * drawn.width * RESOLUTION
        y = drawn.y + random.random() * drawn.height * RESOLUTION
        near, grey = gap(world, x, y), grey_at(drawn, x, y)
        edges = min((each.edge_gap(x, y) for each in (*world.ground, *world.cliffs)), default=inf)
        if edges < REACH:
            continue
        if near <= 0 or world.floor(x, y) is None:
            assert grey == OCCUPIED, (x, y)
        elif near > REACH:
            assert grey in (FREE, UNKNOWN), (x, y)


@pytest.mark.parametrize('name', ['apartment', 'room', 'table'])
def test_free_is_where_a_robot_could_be_and_unknown_what_lies_outside(name):
    world, drawn = shipped(name), map_of(shipped(name))
    start = world.start
    assert grey_at(drawn, start.x, start.y) == FREE
    assert grey_at(drawn, drawn.x + RESOLUTION / 2, drawn.y + RESOLUTION / 2) != FREE
    assert grey_at(drawn, drawn.x - 5, drawn.y) == UNKNOWN


def test_the_program_writes_a_map_that_nav2_can_load(tmp_path: Path):
    path = tmp_path / 'apartment.yaml'
    with simulator('--world', 'apartment', '--export', path) as sim:
        assert sim.ended() == (0, '', '')
    assert sim.said.startswith(f'{path} and {tmp_path / "apartment.pgm"}: a map for Nav2, ')
    described = yaml.safe_load(path.read_text())
    assert described['resolution'] == 0.02
    assert described['image'] == 'apartment.pgm'
    assert described['mode'] == 'trinary' and described['negate'] == 0
    assert 1 - UNKNOWN / 255 > described['free_thresh'] > 1 - FREE / 255
    assert 1 - OCCUPIED / 255 > described['occupied_thresh'] > 1 - UNKNOWN / 255
    drawn = map_of(shipped('apartment'))
    assert described['origin'] == pytest.approx([drawn.x, drawn.y, 0.0], abs=1e-3)
    head, size, depth, cells = (tmp_path / 'apartment.pgm').read_bytes().split(b'\n', 3)
    assert (head, size, depth) == (b'P5', f'{drawn.width} {drawn.height}'.encode(), b'255')
    assert cells == drawn.cells
