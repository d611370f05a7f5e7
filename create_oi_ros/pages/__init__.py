# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Files that the live page and the report share: the map, and the style."""

from importlib import resources


def files() -> dict[str, str]:
    """Return the text of each file, by its name."""
    folder = resources.files(__package__) / 'parts'
    return {each.name: each.read_text('utf-8') for each in folder.iterdir()}
