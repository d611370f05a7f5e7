# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_view`: shows a robot in a terminal, and drives it by keys.

`robot_state` holds what was received. `picture` draws it on a canvas of `characters`, from a
`chart` (the map) and `panels` (the sensors). `keys` maps keys to actions, `teleop` turns drive
keys into velocities. These are pure: no clock, no terminal, no ROS graph. `terminal` and
`view_node` are the two ends, `create_view` joins them.
"""
