# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What stands in a room, as plain numbers for programs that draw it."""

from .geometry import Disc, LineSegment, Polygon
from .world import Pose, World

Numbers = list[float]


def outlines(world: World) -> dict[str, list[Numbers]]:
    """
    Return the parts of a room, in metres and radians.

    Walls are x, y of both ends; posts x, y and radius; cliffs and grounds x, y of their corners;
    Home Bases x, y and heading; virtual walls the same and their reach.
    """
    walls = [each for each in world.obstacles if isinstance(each, LineSegment)]
    posts = [each for each in world.obstacles if isinstance(each, Disc)]
    return {
        'walls': [_rounded(*(value for end in wall.ends for value in end)) for wall in walls],
        'posts': [_rounded(post.x, post.y, post.radius) for post in posts],
        'cliffs': list(map(_corners, world.cliffs)),
        'grounds': list(map(_corners, world.ground)),
        'home_bases': [_pose(base.pose) for base in world.home_bases],
        'virtual_walls': [[*_pose(each.pose), each.reach] for each in world.virtual_walls],
    }


def _rounded(*values: float) -> Numbers:
    return [round(value, 4) for value in values]


def _corners(polygon: Polygon) -> Numbers:
    return _rounded(*(value for edge in polygon.edges for value in edge.ends[0]))


def _pose(pose: Pose) -> Numbers:
    return _rounded(*pose)
