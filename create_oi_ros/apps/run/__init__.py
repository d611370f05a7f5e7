# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_run`: a robot, its node and its web page in one terminal, with a status line.

`create_run` starts and ends the processes, `status` makes and shows the line.
"""
