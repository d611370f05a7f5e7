# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Goals: motions with an end, which the driver pursues frame by frame. Pure."""

from .docking import Dock, Undock
from .goal import Code, Goal, Phase
from .motions import DriveArc, DriveDistance, NavigateToPosition, RotateAngle
