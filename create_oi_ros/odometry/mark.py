# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Where the robot was at a moment, for all tracks.

A reading corrects where the robot is, and also where it was: what it did since then is the
difference. So the pose at a mark is learned on as if it were three more states. They never
change by themselves, and their own covariance is in no sum, so only what they have in common
with the states is kept.
"""

import numpy as np

from . import states as s
from .noise import MOVED
from .request_history import Array


class MarkedPose:
    """The pose at the mark; a row a track."""

    def __init__(self, means: Array, p: Array) -> None:
        """Begin where the tracks are, by their states and the covariances of these."""
        self.poses = means[:, s.POSE].copy()
        self._common = p[:, :, s.POSE].copy()
        """Covariances of the states (second axis) and the pose at the mark."""

    def mean(self, shares: Array) -> tuple[float, float, float]:
        """Return the mean pose at the mark, x, y and yaw, of tracks with these shares."""
        x, y, yaw = (shares @ self.poses).tolist()
        return x, y, yaw

    def advance(self, transition: Array) -> None:
        """Let the states `MOVED` follow from all, by a matrix a track."""
        self._common[:, MOVED] = transition @ self._common

    def cut(self, columns: Array, index: int, shift: Array, less: Array) -> None:
        """
        Learn what the tracks have learned of a state.

        A track's mean has moved by its `shift` times the state's column of the covariance, which
        has shrunk by `less` times that column's square.
        """
        row = self._common[:, index].copy()
        self.poses += row * shift[:, None]
        self._common -= np.einsum('ti,tj->tij', less[:, None] * columns, row)

    def scale(self, index: int, factors: Array) -> None:
        """Let a state become a multiple of itself, by a factor a track."""
        self._common[:, index] *= factors[:, None]

    def clear(self, index: int) -> None:
        """Forget what a state tells of the mark."""
        self._common[:, index] = 0.0

    def keep(self, order: list[int]) -> None:
        """Keep these tracks, in this order."""
        self.poses, self._common = self.poses[order], self._common[order]

    def join(self, count: int) -> None:
        """Let as many tracks join that begin where the best one is, and know nothing else."""
        poses, common = self.poses[:1], np.zeros_like(self._common[:1])
        common[:, s.POSE] = self._common[:1, s.POSE]
        self.poses = np.concatenate([self.poses, poses.repeat(count, axis=0)])
        self._common = np.concatenate([self._common, common.repeat(count, axis=0)])
