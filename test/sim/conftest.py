# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the tests of `create_sim` have its port."""

from pathlib import Path

import pytest


@pytest.fixture
def port(tmp_path: Path) -> Path:
    """Return the path of the simulator's link."""
    return tmp_path / 'create'
