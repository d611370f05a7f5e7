# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""How exactly the simulator compares times."""

TOLERANCE = 1e-6
"""Seconds by which a sum of floats may fall short of the time it stands for."""
