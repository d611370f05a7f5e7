# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What coverage does not measure."""

import pytest

UNMEASURED = pytest.mark.no_cover
"""For long drives: short tests run the same lines, and measuring makes these 2.5 times as long."""
