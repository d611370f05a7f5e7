# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Wheels of the odometry, rolled at once."""

from create_oi_ros.odometry.wheel_model import WheelModel


def roll(wheels: WheelModel, seconds: float, scales: tuple[float, float]) -> None:
    """Let time pass, and the copies of the wheels roll in one step; true over counted travel."""
    wheels.wait(seconds)
    wheels.catch_up(seconds, scales)
