# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Room files, what a robot senses in rooms, and maps of them."""

from math import cos, floor, hypot, inf, radians, sin
from pathlib import Path
from random import Random
from statistics import mean, median

import numpy as np
import pytest
import yaml

from bench_gyro import learned, REST, SHEET
from create_oi_ros.driver import Settings
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.surroundings import CLIFF_BELOW
from create_oi_ros.sim.world import parse, Pose, shipped, shipped_names, World, WorldError
from create_oi_ros.sim.world.floor_plan import FREE, Map, map_of, OCCUPIED, RESOLUTION, UNKNOWN
from create_oi_ros.sim.world.geometry import reach
from create_oi_ros.sim.world.lidar import BEARINGS, Lidar, NOISE
from create_oi_ros.sim.world_files import read_world
from lap import lap
from support.nightly import NIGHTLY
from support.simulator import simulator

FRAME = 0.015


def sensed(text, pose=None):
    body = Body(parse(text, 'test'))
    if pose is not None:
        body.place(Pose(pose[0], pose[1], radians(pose[2])))
    return body.sense()


# The text.


@pytest.mark.parametrize('name', ['apartment', 'empty', 'room', 'table'])
def test_in_a_shipped_world_the_robot_starts_free_and_on_the_floor(name):
    body = Body(shipped(name))
    assert body.truth().pose == shipped(name).start
    sense = body.sense()
    assert not any((sense.bump_left, sense.bump_right, sense.drop_left, sense.drop_right,
                    sense.drop_caster, sense.cliff_left, sense.cliff_right,
                    sense.cliff_front_left, sense.cliff_front_right, sense.virtual_wall))


@pytest.mark.parametrize(('line', 'message'), [
    ('wal 0 0 1 1', "unknown 'wal'; allowed: start, floor, patch, ground, cliff, wall"),
    ('wall 0 0 1', "3 numbers after 'wall'; allowed: \"wall X Y X Y ...\""),
    ('wall 0 0 1 1 2', "5 numbers after 'wall'"),
    ('start 0 0 0 0', "4 numbers after 'start'"),
    ('wall 0 0 0 0', 'has no length'),
    ('box 0 0 1', "3 numbers after 'box'; allowed: \"box X Y X Y\""),
    ('box 1 1 1 2', 'has no length'),
    ('start 0 zero 0', "'zero' is not a number"),
    ('start 0 nan 0', "'nan' is not a number"),
    ('post 1 0 1e200', "'1e200'; allowed: -1000000 to 1000000"),
    ('wall 0 0 -1e300 1', "'-1e300'; allowed: -1000000 to 1000000"),
    ('floor 1.5', 'reflectance 1.5; allowed: 0 to 1'),
    ('patch 2 0 0 1 0 1 1', 'reflectance 2.0'),
    ('patch 0.5 0 0 1 0', "5 numbers after 'patch'"),
    ('post 0 0 0', 'radius 0.0; allowed: above 0'),
    ('cliff 0 0 1 0', "4 numbers after 'cliff'"),
    ('virtual_wall 0 0 0 0', 'a beam of 0.0 metres'),
])
def test_a_wrong_line_is_refused_with_name_line_and_what_is_allowed(line, message):
    with pytest.raises(WorldError) as caught:
        parse(f'# first\n{line}\n', 'den')
    assert str(caught.value).startswith('den, line 2: ')
    assert message in str(caught.value)


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path: Path):
    file = tmp_path / 'den.world'
    file.write_text('start 1 2 0\n', 'utf-8-sig')
    assert read_world(str(file)).start == Pose(1.0, 2.0, 0.0)


# Walls.

def test_the_wall_sensor_looks_to_the_right_and_its_signal_falls_with_distance():
    right = sensed('wall -1 -0.2 1 -0.2')
    assert right.wall and right.wall_signal > 600
    left = sensed('wall -1 0.2 1 0.2')
    assert not left.wall and left.wall_signal == 0
    signals = [sensed(f'wall -1 {-y} 1 {-y}').wall_signal for y in (0.17, 0.2, 0.25, 0.28, 0.4)]
    assert signals == sorted(signals, reverse=True)
    assert signals[0] > signals[1] > signals[2] > signals[3] > signals[4] == 0


# Floors.

def test_the_cliff_signal_follows_the_floor_below_its_sensor():
    dark, light = sensed('floor 0.2'), sensed('floor 0.8')
    assert dark.cliff_left_signal == pytest.approx(500, abs=16)
    assert light.cliff_left_signal == pytest.approx(2000, abs=16)
    assert not dark.cliff_left
    black = sensed('floor 0.02')
    assert black.cliff_front_left and not black.drop_caster, 'it looks like a cliff'
    sense = sensed('floor 0.2 \n patch 0.8 0 0 1 0 1 1 0 1')
    assert sense.cliff_left_signal > 1900 and sense.cliff_front_left_signal > 1900
    assert sense.cliff_right_signal < 600 and sense.cliff_front_right_signal < 600


@pytest.mark.parametrize(('pose', 'cliffs'), [
    ((0, 0, 0), ()),
    ((0.86, 0, 0), ('front_left', 'front_right')),
    ((0.90, 0, 90), ('right',)),
    ((0.90, 0, -90), ('left',)),
    ((0.95, 0, 0), ('left', 'front_left', 'front_right', 'right')),
    ((0.95, 0, 180), ()),
])
def test_at_the_edge_of_a_table_the_sensors_over_it_see_the_cliff(pose, cliffs):
    body = Body(shipped('table'))
    body.place(Pose(pose[0], pose[1], radians(pose[2])))
    for side in ('left', 'front_left', 'front_right', 'right'):
        assert getattr(body.sense(), f'cliff_{side}') is (side in cliffs), side
        over = getattr(body.sense(), f'cliff_{side}_signal') < CLIFF_BELOW
        assert over is (side in cliffs)


def test_driving_off_an_edge_the_caster_drops_then_the_wheels_and_the_robot_hangs():
    body = Body(shipped('table'))
    body.drive(right=0.2, left=0.2)
    seen = []
    for _ in range(800):
        body.step(FRAME)
        sense = body.sense()
        for name in ('cliff_front_left', 'drop_caster', 'drop_left', 'drop_right'):
            if getattr(sense, name) and name not in seen:
                seen.append(name)
    assert seen[:2] == ['cliff_front_left', 'drop_caster']
    assert set(seen[2:]) == {'drop_left', 'drop_right'}
    assert body.truth().pose.x == pytest.approx(1, abs=0.01)
    assert body.truth().speed == 0
    assert body.truth().measured_travelled > 2


# Beams.

BASE = 'home_base 0 0 0'


@pytest.mark.parametrize(('pose', 'character', 'walled'), [
    ((2.0, 0, 180), 252, False),         # on the axis: both buoys
    ((2.0, 0.5, 180), 248, False),       # to the right of a robot that comes in: red
    ((2.0, -0.5, 180), 244, False),      # to its left: green
    ((0.4, 0, 180), 254, True),          # both, and the force field
    ((0.45, 0.15, 180), 250, True),
    ((0.45, -0.15, 180), 246, True),
    ((0.2, 0.4, 180), 242, True),        # beside the buoys: the force field only
    ((4.0, 0, 180), 255, False),         # too far
    ((-1.0, 0, 0), 255, False),          # behind
])
def test_the_home_bases_beams_are_the_manuals_characters(pose, character, walled):
    sense = sensed(BASE, pose)
    assert (sense.infrared, sense.virtual_wall) == (character, walled)


@pytest.mark.parametrize(('pose', 'seen'), [
    ((1.5, 0, 0), True), ((1.5, 0.5, 0), False), ((2.5, 0, 0), False), ((-0.5, 0, 180), False),
    ((-0.3, 0, 0), True)])
def test_a_virtual_wall_is_seen_in_its_beam_and_halo(pose, seen):
    sense = sensed('virtual_wall 0 0 0 2', pose)
    assert sense.virtual_wall is seen
    assert sense.infrared == 255


# Docking.

@pytest.mark.parametrize('pose', [(0.165, 0.05, 180), (0.165, 0, 150), (0.2, 0, 180)])
def test_askew_aside_or_short_is_not_docked(pose):
    assert not sensed(BASE, pose).home_base


# The simulated lidar: its beams against the walls, and its scans along the odometry.


def scanned(world: World, poses: list[Pose]) -> list[dict]:
    """Return the scans of a robot that moves from one pose to the next in each slot."""
    lidar, found = Lidar(world, 0.0, poses[0]), []
    for number, pose in enumerate(poses, 1):
        lidar.step(number * FRAME, pose)
        if lidar.scans > len(found):
            found.append(lidar.report(number * FRAME))
    return found


@pytest.mark.parametrize('name', ['room', 'apartment', 'table'])
def test_a_beam_ends_at_the_first_thing_in_its_way(name):
    world = shipped(name)
    x, y, yaw = world.start
    scan, = scanned(world, [world.start] * 7)
    for bearing, far in zip(BEARINGS, scan['ranges']):
        true = reach(world.obstacles, x, y, cos(yaw + bearing), sin(yaw + bearing))
        if far is None:
            assert not 0.12 + 4 * NOISE < true < 8.0 - 4 * NOISE
        else:
            assert far == pytest.approx(true, abs=5 * NOISE)


def test_distances_are_measured_from_12_cm_to_8_m_with_1_cm_of_noise():
    near_and_far = parse('wall -0.05 -9 -0.05 9 \n wall 8.5 -9 8.5 9 \n wall -9 2 9 2', 'walls')
    scans = scanned(near_and_far, [Pose()] * 700)
    assert all(scan['ranges'][0] is scan['ranges'][180] is None for scan in scans)
    beside = [scan['ranges'][270] for scan in scans]
    assert len(beside) == 105
    assert np.mean(beside) == pytest.approx(2.0, abs=0.005)
    assert np.std(beside) == pytest.approx(NOISE, rel=0.3)


def off_the_walls(world: World, scan) -> float:
    """Return how far the ends of the beams are off the nearest obstacle, metres, in the median."""
    gaps = []
    for x, y in zip(scan.x, scan.y):
        if np.isfinite(x):
            gaps.append(min((abs(each.gap(x, y)) for each in world.obstacles), default=inf))
    return float(np.median(gaps))


@NIGHTLY
def test_scans_along_the_odometry_draw_the_walls_again_after_a_lap():
    """
    The last scan of a lap, and half of all, of known robots with a gyro.

    The last one in the median of nine robots, since one lap of three is off by more: the noise of
    such a gyro alone turns a lap by half a degree.
    """
    world, gaps = shipped('apartment'), []
    for seed in range(810, 819):
        settings = Settings(robot=learned(seed), gyro=SHEET)
        scans = list(lap(world, settings=settings, seed=seed, stand=REST))
        gaps.append([off_the_walls(world, scan) for scan in [*scans[::10], scans[-1]]])
    print('Gaps at the end, cm:', *(round(100 * each[-1], 1) for each in gaps))
    assert median(each[-1] for each in gaps) < 0.03
    assert mean(median(each) for each in gaps) < 0.03


# Worlds as maps for Nav2, against the worlds' own geometry.


REACH = hypot(RESOLUTION, RESOLUTION)
"""Metres by which a cell may differ from what is exactly there."""


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
        near = min((each.gap(x, y) for each in world.obstacles), default=inf)
        edges = min((each.edge_gap(x, y) for each in (*world.ground, *world.cliffs)), default=inf)
        if edges < REACH:
            continue
        grey = grey_at(drawn, x, y)
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


def test_a_world_that_is_too_large_for_a_map_is_refused(tmp_path: Path):
    world, path = tmp_path / 'hall.world', tmp_path / 'hall.yaml'
    world.write_text('wall 0 0 1000 500\n')
    with simulator('--world', world, '--export', path) as sim:
        code, _, said = sim.ended()
    assert code == 1 and f'create_sim: {world}: 1001 m by 501 m is too large for a map' in said
    assert not path.exists()
