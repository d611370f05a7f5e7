# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of characters for terminals: a canvas with colours, box lines, Braille dots. Pure."""
