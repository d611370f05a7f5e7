# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Looks for mistakes in the ROS graph that ROS itself does not report.

Three are common: two drivers of one name, two nodes that publish `cmd_vel` at once, and a
publisher whose message type the driver does not take.
"""

from collections.abc import Callable
import os
import time

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo

from .topics import CMD_VEL, type_name

UNNAMED = '_NODE_NAME_UNKNOWN_'
"""What ROS calls a node that it has not heard of yet, though its publisher was found."""
INTRODUCTION, LOOK = 1.0, 0.02
"""Seconds in which ROS hears of a node whose publisher it knows, and between two looks."""
ROBOTS_APART = 'give each robot a namespace, or another ROS_DOMAIN_ID'


class GraphWatch:
    """Warns once for each mistake, and again when it comes back in another form."""

    def __init__(self, node: Node, velocity_type: type, warn: Callable[[str], None]) -> None:
        """Watch the `cmd_vel` of a node that subscribes to this type."""
        self._node = node
        self._type = type_name(velocity_type)
        self._topic = node.resolve_topic_name(CMD_VEL)
        self._warn = warn
        self._warned: set[str] = set()
        self.publishers: tuple[str, ...] = ()
        """Nodes that publish `cmd_vel` with the right type, sorted."""
        self._were_unnamed = False
        """Whether a publisher had no name at the last look."""

    def check(self) -> None:
        """Look at the graph, and warn of new mistakes; called once a second."""
        found = self._node.get_publishers_info_by_topic(self._topic)
        # Most have a name at the next look; a program that is no ROS node never gets one.
        are_unnamed = any(each.node_name == UNNAMED for each in found)
        sources = {(node_name(each), _short(each.topic_type)) for each in found
                   if each.node_name != UNNAMED or self._were_unnamed}
        self._were_unnamed = are_unnamed
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
        names = [full_name(namespace, name)
                 for name, namespace in self._node.get_node_names_and_namespaces()]
        return {name for name in names if names.count(name) > 1}


def node_name(endpoint: TopicEndpointInfo) -> str:
    """Return the full name of the node of a publisher, as people know it."""
    if endpoint.node_name == UNNAMED:
        return 'a program without a node name'
    return full_name(endpoint.node_namespace, endpoint.node_name)


def full_name(namespace: str, name: str) -> str:
    """Return the name of a node with its namespace."""
    return f'{namespace.rstrip("/")}/{name}'


def names_of_publishers(node: Node, topic: str) -> set[str]:
    """Return the full names of the nodes that publish a topic; wait a moment for new ones."""
    until = time.monotonic() + INTRODUCTION
    while True:
        found = node.get_publishers_info_by_topic(node.resolve_topic_name(topic))
        if time.monotonic() > until or all(each.node_name != UNNAMED for each in found):
            return {node_name(each) for each in found}
        time.sleep(LOOK)


def _short(type_: str) -> str:
    """Return a type as people write it: geometry_msgs/Twist."""
    package, _, name = type_.partition('/')
    return f'{package}/{name.rpartition("/")[2]}'


def _domain() -> str:
    return os.environ.get('ROS_DOMAIN_ID', '0')
