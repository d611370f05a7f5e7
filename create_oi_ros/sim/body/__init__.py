# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The robot's body: wheels, encoders, bumper, sensors and battery, in a world."""

from ...robot import Rounding
from .body import Body
from .config import BodyConfig
