# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A simulated Create: the robot's side of the Open Interface.

`world` is the room, `body` the robot's mechanics and battery in it, `firmware` what the robot
does with each byte, `server` the pty or TCP port that other programs open. All but `server` are
pure: time is an argument, random numbers come from a seed, and nothing is read or written.
"""
