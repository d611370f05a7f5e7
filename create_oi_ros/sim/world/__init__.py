# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Rooms: walls, floors, cliffs, virtual walls, Home Bases, and the files that describe them."""

from .world import HomeBase, parse, Pose, shipped, shipped_names, VirtualWall, World, WorldError
