# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Looks for mistakes in the ROS graph that ROS itself does not report.

These are two drivers of one name, or with the same frames, and commands that the driver does not
get: of another message type, or in another namespace.
"""

from collections.abc import Iterator
from contextlib import suppress
from functools import partial

from create_oi_msgs.msg import Mode
from rclpy.node import Node
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from . import topics
from .parameters import Parameters
from .topics import CMD_VEL, type_name
from .velocity import COMMANDS, MODE_TYPE, UNNAMED, VelocityInput


class GraphWatch:
    """Warns once for each mistake, and again when it comes back in another form."""

    def __init__(self, node: Node, velocity: VelocityInput, parameters: Parameters) -> None:
        """Watch the partners of a node; `velocity` is its subscription, adapted to them."""
        self._node = node
        self._velocity = velocity
        self._parameters = parameters
        self._topic = node.resolve_topic_name(CMD_VEL)
        self._warned: set[str] = set()
        self._drivers = 0
        """Nodes with our name, or publishers of `mode`, ours among them."""
        self._modes: dict[str, Subscription | None] = {}
        """Subscriptions to other drivers, by the names of their topics `mode`; None: refused."""
        self._base_frames: dict[str, str] = {}
        """Base frames of these drivers."""
        self.publishers: tuple[str, ...] = ()
        """Nodes that publish `cmd_vel` with the right type, sorted."""

    def check(self) -> bool:
        """
        Look at the graph, and warn of new mistakes; called once a second.

        Return whether another driver with our topics has ended: what it published last may be
        what subscribers hold for ours.
        """
        warnings = {*self._wrong_types(), *self._other_topics()}
        own, domain = self._node.get_fully_qualified_name(), self._node.context.get_domain_id()
        names = self._node.get_fully_qualified_node_names()
        if names.count(own) > 1:
            warnings.add(f'another node is called {own} in ROS domain {domain}, so two '
                         'drivers obey the same cmd_vel: give each robot a namespace, or another '
                         'ROS_DOMAIN_ID')
        for warning in sorted(warnings - self._warned):
            self._node.get_logger().warning(warning)
        self._warned = warnings
        # A name may be seen a look before its publishers, and both may be gone at the next one.
        before, self._drivers = self._drivers, max(
            names.count(own), self._node.count_publishers(topics.MODE.name))
        return self._drivers < before

    def _wrong_types(self) -> Iterator[str]:
        found = self._node.get_publishers_info_by_topic(self._topic)
        self._velocity.adapt(found)
        ours = [each for each in found if COMMANDS.get(each.topic_type) is self._velocity.type]
        self.publishers = tuple(sorted(set(map(node_name, ours))))
        for each in found:
            if each not in ours and each.node_name != UNNAMED:  # it will have a name
                yield self._wrong_type(node_name(each), each.topic_type)

    def _wrong_type(self, name: str, type_: str) -> str:
        what = (f'{name} publishes {self._topic} as {type_.replace("/msg/", "/")}, but this '
                f'driver takes {type_name(self._velocity.type)}: its commands are ignored. ')
        if type_ not in COMMANDS:
            return f'{what}Change the publisher'
        if self._parameters.cmd_vel_type == 'auto':
            return f'{what}Let all publishers send the same type, or end those of one'
        return f'{what}Start the driver with cmd_vel_type: auto, or change the publisher'

    def _other_topics(self) -> Iterator[str]:
        """Find commands in another namespace, and other drivers with the same frames."""
        own = self._node.resolve_topic_name(topics.MODE.name)
        for topic, types in self._node.get_topic_names_and_types():
            if MODE_TYPE in types and topic != own:
                yield from self._same_frames(topic)
            # Only one of both is in a namespace; else another robot is meant.
            if (topic.endswith(f'/{CMD_VEL}') and topic != self._topic
                    and f'/{CMD_VEL}' in (topic, self._topic)
                    and self._node.count_publishers(topic)
                    and not self._node.count_subscribers(topic)):
                names = ', '.join(sorted(self._names_of_publishers(topic)))
                yield (f'{names} publishes {topic}, to which nobody listens; '
                       f'this driver listens to {self._topic}: start both in the same namespace, '
                       f'or give one of them -r cmd_vel:=TOPIC')

    def _same_frames(self, topic: str) -> Iterator[str]:
        """Compare frames with a driver that publishes its mode on another topic."""
        if not self._parameters.publish_tf:
            return
        publishers = self._names_of_publishers(topic)
        if publishers and topic not in self._modes:
            self._modes[topic] = None
            with suppress(RuntimeError):  # in a secured domain it is not allowed
                self._modes[topic] = self._velocity.node.create_subscription(
                    Mode, topic, partial(self._on_mode, topic), topics.LATCHED)
        elif not publishers and (ended := self._modes.pop(topic, None)) is not None:
            self._velocity.node.destroy_subscription(ended)
            self._base_frames.pop(topic, None)
        tf, base = self._node.resolve_topic_name(topics.TF.name), self._parameters.base_frame
        others = publishers & self._names_of_publishers(tf)
        if others and self._base_frames.get(topic) == base:
            robot = self._node.get_namespace().strip('/') or 'robot1'
            yield (f'{", ".join(sorted(others))} publishes a transform to {base} on {tf}, '
                   'as this driver does, so the robot jumps between two poses: give each robot '
                   f'frames of its own, such as odom_frame: {robot}/odom and base_frame: '
                   f'{robot}/base_footprint')

    def _on_mode(self, topic: str, message: Mode) -> None:
        self._base_frames[topic] = message.header.frame_id

    def _names_of_publishers(self, topic: str) -> set[str]:
        return {node_name(each) for each in self._node.get_publishers_info_by_topic(topic)}


def node_name(endpoint: TopicEndpointInfo) -> str:
    """Return the full name of the node of a publisher."""
    return f'{endpoint.node_namespace.rstrip("/")}/{endpoint.node_name}'
