# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A simulated Create that other programs open like a serial port.

`serve` runs one robot on one line in real time, `control` lets other programs change its
world, `replay` replays a captured robot, and `create_sim` is the executable.
"""

from .create_sim import main
from .serve import Server
