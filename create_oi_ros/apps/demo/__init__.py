# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_demo`: a simulated robot drives a tour, which is recorded and reported.

`pilot` drives and waits for what the robot reports, `tour` lists the steps, `create_demo` starts
and ends the processes.
"""
