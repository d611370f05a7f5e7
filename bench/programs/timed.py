# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The node with a profile of its reading thread: `timed.py [ROS ARGUMENTS]`.

The main methods that the thread calls are wrapped, and the thread's processor time is taken around
each. A call inside another wrapped call is counted once, as the inner one. Counting begins after
SETTLE reads of the port. On SIGTERM it prints JSON: the thread's processor time, and for each
method the number of calls and the nanoseconds spent.
"""

from collections import Counter
from collections.abc import Callable
import functools
import json
from threading import get_ident
from time import thread_time_ns
from typing import Any

from rclpy.publisher import Publisher

from create_oi_ros.driver import Driver
from create_oi_ros.driver.tracking import Tracking
from create_oi_ros.link.port import Port
from create_oi_ros.odometry import Odometry
from create_oi_ros.oi import StreamReader
from create_oi_ros.ros import publishing
from create_oi_ros.ros.node import main
from create_oi_ros.ros.publishing import FramePublisher
from create_oi_ros.ros.serialized import Fill, Packing

SETTLE = 270
"""Reads of the port, one for each frame, before counting: ROS nodes need time for discovery."""


class Profile:
    """Calls and processor time of methods, on the thread that calls `Port.read`."""

    def __init__(self) -> None:
        """Begin with no calls."""
        self._thread: int | None = None
        self._inside = 0
        self._begun = self._ended = 0
        self.calls: Counter[str] = Counter()
        self.spent: Counter[str] = Counter()

    def wrap(self, owner: type, name: str) -> None:
        """Replace a method of a class by one that is measured."""
        method, key = getattr(owner, name), f'{owner.__name__}.{name}'

        @functools.wraps(method)
        def measured(*arguments: Any, **named: Any) -> Any:
            if key == 'Port.read':
                self._next_round()
            if get_ident() != self._thread:
                return method(*arguments, **named)
            return self._timed(key, functools.partial(method, *arguments, **named))

        setattr(owner, name, measured)

    def wrap_sending(self) -> None:
        """Measure as `Publisher.publish` also what sends the messages that are bytes."""
        sending = publishing.sending

        def measured(publisher: Publisher, fill: Fill) -> Callable[[Any], None]:
            send = sending(publisher, fill)
            if not isinstance(fill, Packing):
                return send
            return lambda message: self._timed(
                'Publisher.publish', functools.partial(send, message))

        publishing.sending = measured

    def _next_round(self) -> None:
        """Note the time at which the thread reads again; begin to count after SETTLE reads."""
        self._thread, self._ended = get_ident(), thread_time_ns()
        if self.calls['Port.read'] == SETTLE and not self._begun:
            self._begun = self._ended
            self.calls.clear()
            self.spent.clear()

    def _timed(self, key: str, work: Callable[[], Any]) -> Any:
        before, self._inside = self._inside, 0
        begun = thread_time_ns()
        try:
            return work()
        finally:
            took = thread_time_ns() - begun
            self.spent[key] += took - self._inside
            self.calls[key] += 1
            self._inside = before + took

    def result(self) -> dict[str, Any]:
        """Return what is printed."""
        return {'thread': self._ended - self._begun, 'calls': self.calls, 'spent': self.spent}


profile = Profile()
profile.wrap(Port, 'read')
profile.wrap(Driver, 'receive')
profile.wrap(StreamReader, 'next_event')
profile.wrap(Tracking, 'take')
profile.wrap(Odometry, 'update')
profile.wrap(FramePublisher, 'publish')
profile.wrap(Publisher, 'publish')
profile.wrap_sending()
profile.wrap(Driver, 'poll')
code = main()
print(json.dumps(profile.result()))
raise SystemExit(code)
