# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Code that tests share: simulated robots, ROS processes, terminals, bags, documentation pages."""
