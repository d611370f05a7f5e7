# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Keeps subscriptions out of rclpy's executor, so that their messages can be taken otherwise."""

from typing import Any

from rclpy.callback_groups import CallbackGroup


class NoExecutor(CallbackGroup):
    """A group of which no executor runs anything."""

    def can_execute(self, entity: Any) -> bool:
        """Keep executors from waiting for an entity."""
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """Keep executors from running an entity."""
        return False

    def ending_execution(self, entity: Any) -> None:
        """Take note of nothing."""
