# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A plugin of pytest for mutants: nobody reads how they fail, so hypothesis shrinks nothing."""

from hypothesis import Phase, settings


def pytest_sessionstart() -> None:
    """Take the settings of all tests, but stop at the first failure."""
    settings.register_profile(
        'unshrunk', parent=settings(), phases=(Phase.explicit, Phase.generate),
        report_multiple_bugs=False)
    settings.load_profile('unshrunk')
