# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The ROS side: node, parameters, topics, services, diagnostics; how programs start and end."""
