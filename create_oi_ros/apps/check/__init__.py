# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_check`: five guided minutes with a robot that show how it drives and counts."""
