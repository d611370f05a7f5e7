# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Bytes to and from the world: serial port, session thread, dead-man, capture. No ROS."""
