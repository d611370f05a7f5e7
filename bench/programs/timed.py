"""
The node, and what each step of it takes of the processor: `timed.py [ROS ARGUMENTS]`.

The steps of the thread that reads the port are wrapped, and thread time is taken around each; what
a step takes of another inside it is not counted twice. After SETTLE readings of the port it begins
to count. On SIGTERM it prints, as JSON, the frames since then, the thread's time, and for each
step how often it came and the nanoseconds that it took.
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
from create_oi_ros.ros.node import main
from create_oi_ros.ros.publishing import FramePublisher

SETTLE = 270
"""Readings of the port, one a frame, until all have found each other: 3 s where one was missed."""


class Ledger:
    """What the steps of one thread take, the first of which is to read."""

    def __init__(self) -> None:
        """Begin with an empty one."""
        self._thread: int | None = None
        self._inside = 0
        self._begun = self._ended = 0
        self.calls: Counter[str] = Counter()
        self.spent: Counter[str] = Counter()

    def step(self, owner: type, name: str) -> None:
        """Watch over a method of a class."""
        method, key = getattr(owner, name), f'{owner.__name__}.{name}'

        @functools.wraps(method)
        def watched(*arguments: Any, **named: Any) -> Any:
            if key == 'Port.read':
                self._begin_again()
            if get_ident() != self._thread:
                return method(*arguments, **named)
            return self._timed(key, functools.partial(method, *arguments, **named))

        setattr(owner, name, watched)

    def _begin_again(self) -> None:
        """Note that the thread begins another round."""
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

    def told(self) -> dict[str, Any]:
        """Tell it all."""
        return {'thread': self._ended - self._begun, 'calls': self.calls, 'spent': self.spent}


ledger = Ledger()
ledger.step(Port, 'read')
ledger.step(Driver, 'receive')
ledger.step(StreamReader, 'next_event')
ledger.step(Tracking, 'take')
ledger.step(Odometry, 'update')
ledger.step(FramePublisher, 'publish')
ledger.step(Publisher, 'publish')
ledger.step(Driver, 'poll')
code = main()
print(json.dumps(ledger.told()))
raise SystemExit(code)
