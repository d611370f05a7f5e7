# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Coroutines of asyncio that wait for a driver, and for what it answers."""

import asyncio
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.task import Future

from .waiting import DISCOVERY_TIMEOUT, other_user, POLL_INTERVAL

REPLY_TIMEOUT = 10.0
"""Seconds in which a driver must answer a request, or accept a goal."""


async def found(node: Node, name: str, offered: Callable[[], bool]) -> None:
    """Wait until an action or a service is offered to a node; TimeoutError: no driver does."""
    for _ in range(round(DISCOVERY_TIMEOUT / POLL_INTERVAL)):
        if offered():
            return
        await asyncio.sleep(POLL_INTERVAL)
    raise TimeoutError(f'no driver offers {node.resolve_service_name(name)} in ROS domain '
                       f'{node.context.get_domain_id()}')


async def answer_of(future: Future, node: Node, timeout: float = REPLY_TIMEOUT) -> Any:
    """Return what a node's driver answers; TimeoutError: nothing in so many seconds."""
    done = asyncio.Event()
    future.add_done_callback(lambda _: done.set())
    try:
        await asyncio.wait_for(done.wait(), timeout)
    except TimeoutError:
        why = other_user(node)
        raise TimeoutError(f'the driver does not answer within {timeout:g} s'
                           + (f': {why}' if why else '')) from None
    return future.result()
