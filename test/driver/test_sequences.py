# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Any sequence of commands, requests, faults and hands on the robot ends well."""

from campaign.sequences import draw
from support.measuring import UNMEASURED

pytestmark = UNMEASURED


def test_any_sequence_ends_well():
    draw(25, 40, derandomize=True)
