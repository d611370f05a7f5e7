# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Long tests with real processes; `make nightly` runs them, `make test` makes some faults once.

`stage` starts a node and a simulated robot and checks all that the node publishes.
"""
