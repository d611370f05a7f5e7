# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A ROS 2 driver for the iRobot Create, and a simulated Create that speaks the same bytes."""

__version__ = '1.0.0'
