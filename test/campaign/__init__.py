# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Long tests with real processes: the node and a simulated robot, disturbed in many ways.

`faults` makes each fault many times and prints a table, `soak` does everything at once for a long
time, `fuzz` gives mutated bytes to the stream reader. `make faults`, `make soak` and `make fuzz`
run them (see CONTRIBUTING.md); `make test` makes some faults once.

`stage` starts the processes, `watch` checks what the node publishes, `cases` lists the faults.
"""
