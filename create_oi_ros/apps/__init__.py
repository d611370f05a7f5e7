# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The programs, a file or a package each. None imports another; they start each other by name."""
