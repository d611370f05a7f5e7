# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A fault of the campaign: how to make it, what is promised, and the result of one try."""

from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

from campaign.stage import QUICK, Stage


@dataclass
class Result:
    """The result of one try."""

    recovery: float | None = None
    """Seconds from the end of the fault until everything is restored and published again."""
    zero: float | None = None
    """Seconds until the wheels had zero speed requested."""
    wrong: list[str] = field(default_factory=list)
    """Messages with wrong values that were published."""
    trouble: str = ''
    """Why the try failed; empty if it did not."""


Try = Callable[[Stage, Random], Result]
"""A function that makes a fault once and returns what happened."""


@dataclass(frozen=True)
class Fault:
    """One kind of fault, and the limits that are promised for it."""

    name: str
    try_once: Try
    keeps_node: bool = True
    """Whether the same node and robot serve the next try."""
    recovery: float | None = 1.0
    """Limit of `Result.recovery`; None if nothing has to recover."""
    zero: float | None = 1.0
    """Limit of `Result.zero`; None if the wheels do not turn."""
    node: dict[str, object] = field(default_factory=dict)
    """Parameters of the node."""
    robot: tuple[str, ...] = QUICK
    """Options of the simulated robot."""

    def prepare(self, stage: Stage) -> None:
        """Start the robot and the node if the stage has none."""
        if stage.robot is None:
            stage.start_robot(*self.robot)
        if self.keeps_node and stage.node is None:
            stage.start_node(**self.node)
            stage.set_outputs()
