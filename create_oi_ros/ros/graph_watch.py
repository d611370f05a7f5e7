# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Looks for mistakes in the ROS graph that ROS itself does not report.

Three are common: two drivers of one name, two nodes that publish `cmd_vel` at once, and a
publisher whose message type the driver does not take.
"""

from collections.abc import Callable
import os

from rclpy.node import Node

from .reference import type_name

ROBOTS_APART = 'give each robot a namespace, or another ROS_DOMAIN_ID'


class GraphWatch:
    """Warns once for each mistake, and again when it comes back in another form."""

    def __init__(self, node: Node, velocity_type: type, warn: Callable[[str], None]) -> None:
        """Watch the `cmd_vel` of a node that subscribes to this type."""
        self._node = node
        self._type = type_name(velocity_type)
        self._topic = node.resolve_topic_name('cmd_vel')
        self._warn = warn
        self._warned: set[str] = set()
        self.publishers: tuple[str, ...] = ()
        """Nodes that publish `cmd_vel` with the right type, sorted."""

    def check(self) -> None:
        """Look at the graph, and warn of new mistakes."""
        found = self._node.get_publishers_info_by_topic(self._topic)
        sources = {(self._name(each.node_namespace, each.node_name), _short(each.topic_type))
                   for each in found}
        self.publishers = tuple(sorted(
            name for name, type_ in sources if type_ == self._type))
        warnings = {self._wrong_type(name, type_)
                    for name, type_ in sources if type_ != self._type}
        if len(self.publishers) > 1:
            warnings.add(f'{len(self.publishers)} nodes publish {self._topic}: '
                         f'{", ".join(self.publishers)}. The newest command wins, whoever sent '
                         'it: end all but one, or put twist_mux between them')
        own = self._node.get_fully_qualified_name()
        if own in self._duplicate_names():
            warnings.add(f'another node is called {own} in ROS domain {_domain()}, so two '
                         f'drivers obey the same cmd_vel: {ROBOTS_APART}')
        for warning in sorted(warnings - self._warned):
            self._warn(warning)
        self._warned = warnings

    def _wrong_type(self, name: str, type_: str) -> str:
        stamped = 'true' if type_.endswith('TwistStamped') else 'false'
        return (f'{name} publishes {self._topic} as {type_}, but this driver takes {self._type}: '
                f'its commands are ignored. Start the driver with enable_stamped_cmd_vel: '
                f'{stamped}, or change the publisher')

    def _duplicate_names(self) -> set[str]:
        names = [self._name(namespace, name)
                 for name, namespace in self._node.get_node_names_and_namespaces()]
        return {name for name in names if names.count(name) > 1}

    @staticmethod
    def _name(namespace: str, name: str) -> str:
        return f'{namespace.rstrip("/")}/{name}'


def _short(type_: str) -> str:
    """Return a type as people write it: geometry_msgs/Twist."""
    package, _, name = type_.partition('/')
    return f'{package}/{name.rpartition("/")[2]}'


def _domain() -> str:
    return os.environ.get('ROS_DOMAIN_ID', '0')
