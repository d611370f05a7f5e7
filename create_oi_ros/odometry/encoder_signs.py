# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What encoders without direction count, by each track's idea of where they take their signs from.

Arrays are those of `wheel_model`.
"""

from typing import NamedTuple

import numpy as np

from .request_history import Array

NONE, LAST, UPWARD = range(3)
"""Where an encoder takes its sign from: the motion; the last speed asked that was not zero; the
speed asked, where zero counts as forwards."""
SignPair = tuple[Array, Array]
"""Signs of both wheels' requests: kept where these are zero, and upward."""


class Signs(NamedTuple):
    """How each track's encoders take their signs."""

    kinds: Array
    late: Array
    """Whether a request's sign waits for the dead time."""


class Encoders:
    """The encoders of all tracks."""

    def __init__(self, signs: Signs) -> None:
        self._kinds, self._late = set(signs.kinds.tolist()), signs.late[:, None]
        self._of_motion, self._of_last, self._of_request = (
            (signs.kinds == kind)[:, None] for kind in (NONE, LAST, UPWARD))

    def see_motion(self, travel: Array, sign: Array | None) -> bool:
        """Tell whether all count this travel as it is; `sign`: of all requests, if it is one."""
        return self._kinds == {NONE} or sign is not None and bool((travel * sign).min() >= 0)

    def counted(self, travel: Array, rolled: Array, signs: SignPair, late: SignPair | None,
                ) -> Array:
        """
        Return what they make of this travel, in which wheels rolled so far, forth and back.

        `signs`: of the requests; `late`: of those a dead time ago, if these may be others.
        """
        kept, up = signs
        if late is not None:
            kept, up = (np.where(self._late, *both) for both in zip(late, signs))
        if self._kinds == {LAST}:
            return kept * rolled
        return np.where(self._of_motion, travel, np.where(self._of_last, kept, up) * rolled)

    def turned(self, before: SignPair, after: SignPair) -> Array:
        """Return of which wheels of which tracks the sign is another one after a request."""
        kept, up = (now != was for now, was in zip(after, before))
        changed: Array = self._of_last & kept | self._of_request & up
        return changed[:, :, 0]
