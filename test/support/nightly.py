# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What `make nightly` runs, and how much of it: `make nightly SHARE=0.1` runs a tenth."""

import os

import pytest

NIGHTLY = pytest.mark.nightly
UNMEASURED = pytest.mark.no_cover
"""For long drives: short tests run the same lines, and coverage makes these 2.5 times as long."""
SHARE = float(os.environ.get('SHARE', '1'))


def times(whole: int) -> int:
    """Return how often, or how many, of so many; at least one."""
    return max(1, round(SHARE * whole))
