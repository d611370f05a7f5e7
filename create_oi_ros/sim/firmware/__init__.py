# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What the Create does with each byte: by the manual, and by guesses where it is silent."""

from .create import Create
from .guesses import Guesses
