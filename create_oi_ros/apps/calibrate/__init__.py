# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_calibrate`: computes the parameters of the odometry from measured drives."""
