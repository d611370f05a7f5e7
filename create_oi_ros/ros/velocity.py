# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Both ends of `cmd_vel`: the driver's subscription, and what programs publish to it.

The subscription has a small node and a thread of its own. Each time that rclpy's executor wakes,
it gathers everything that it waits for. With the services and actions of the driver's node that
takes a millisecond of processor time. A velocity command, ten or fifty times a second, need not
wait for that.
"""

from collections.abc import Callable, Sequence
from math import inf
import threading

from geometry_msgs.msg import Twist, TwistStamped, Vector3
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from .messages import nanoseconds
from .topics import CMD_VEL, type_name

TYPES: dict[str, tuple[type, ...]] = {
    'auto': (Twist, TwistStamped), 'twist': (Twist,), 'stamped': (TwistStamped,)}
"""Message types to choose from, for each value of the parameter `cmd_vel_type`."""
RELIABLE_CHECKS = 10
"""Checks of the publishers in a row that must all be reliable, until the subscription is again."""
MODE_TYPE = 'create_oi_msgs/msg/Mode'
COMMANDS: dict[str, type] = {
    f'geometry_msgs/msg/{type_.__name__}': type_ for type_ in (Twist, TwistStamped)}
UNNAMED = '_NODE_NAME_UNKNOWN_'
"""What ROS calls a node that it has not heard of yet, though an endpoint of it was found."""
CHECK_INTERVAL, SEARCH_INTERVAL = 1.0, 0.2
"""Seconds between two looks for the driver, when it was there and when it was not."""
UNUSED_CHECKS = 10
"""Checks without a command after which the publisher ends."""
STOP_TIMEOUT = Duration(seconds=1.0)
"""How long to wait until the last command has arrived."""


class VelocityInput:
    """
    Subscribes to `cmd_vel` in the way that its publishers need, one subscription at a time.

    It is reliable while all publishers are, so that a single zero is not lost, and best effort
    while one of them is not: a reliable subscription would get nothing from that one.
    """

    def __init__(self, node: Node, type_: str,
                 on_command: Callable[[float, float, int], None],
                 *, on_failure: Callable[[], None]) -> None:
        """
        Subscribe for a node, with one of TYPES; `start` begins to take commands.

        `on_command` gets forward speed, m/s, turn rate, rad/s, and the stamp, ns; 0: none.
        `on_failure` is called when the thread ends with an error, whose traceback is printed.
        """
        self._topic = node.resolve_topic_name(CMD_VEL)
        # Remaps of the process are in the topic's name already; `__node` is for the other node.
        self.node = Node(
            f'{node.get_name()}_{CMD_VEL}', context=node.context, namespace=node.get_namespace(),
            use_global_arguments=False, enable_rosout=False, start_parameter_services=False,
            parameter_overrides=[Parameter('start_type_description_service', value=False)])
        self._types = TYPES[type_]
        self._on_command = on_command
        self._on_failure = on_failure
        self.type = self._types[0]
        """The message type of the subscription."""
        self.reliability = ReliabilityPolicy.RELIABLE
        """The reliability that it asks for."""
        self._reliable_checks = 0
        self._subscription: Subscription | None = None
        self._refused = False
        """Whether the middleware refused the last subscription."""
        self._subscribe()
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(self.node)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=CMD_VEL)

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """Take no more commands; nobody calls `adapt` any more, and `on_command` has returned."""
        if self._thread.is_alive():
            self._executor.create_task(self._closing.set)
            self._thread.join()
        self._executor.shutdown()
        self.node.destroy_node()

    def adapt(self, publishers: Sequence[TopicEndpointInfo]) -> None:
        """
        Subscribe anew if these publishers need it; called about once a second.

        The type changes when all publishers have the other one. Where both are published, the
        subscription stays as it is.
        """
        offered = [type_ for type_ in self._types
                   if any(COMMANDS.get(each.topic_type) is type_ for each in publishers)]
        type_ = offered[0] if len(offered) == 1 else self.type
        taken = [each.qos_profile.reliability for each in publishers
                 if COMMANDS.get(each.topic_type) is type_]
        reliability = self.reliability
        if ReliabilityPolicy.BEST_EFFORT in taken:
            self._reliable_checks, reliability = 0, ReliabilityPolicy.BEST_EFFORT
        elif taken:
            # A publisher that comes and goes, over a bad network, must not cost a new
            # subscription each time.
            self._reliable_checks += 1
            if self._reliable_checks >= RELIABLE_CHECKS:
                reliability = ReliabilityPolicy.RELIABLE
        if (type_, reliability) != (self.type, self.reliability) or self._refused:
            self.type, self.reliability, self._refused = type_, reliability, False
            self._executor.create_task(self._subscribe)

    def _subscribe(self) -> None:
        if self._subscription is not None:
            self.node.destroy_subscription(self._subscription)
            self._subscription = None
        try:
            self._subscription = self.node.create_subscription(
                self.type, self._topic, self._take,
                QoSProfile(depth=1, reliability=self.reliability),
                # GraphWatch says more of a publisher that does not fit.
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False))
        except RuntimeError as error:  # another node of this process may have the other type yet
            self._refused = True
            self.node.get_logger().warning(
                f'{self._topic} as {type_name(self.type)}: {error}; tried again in a second')

    def _take(self, message: Twist | TwistStamped) -> None:
        stamped = isinstance(message, TwistStamped)
        twist = message.twist if stamped else message
        stamp = nanoseconds(message.header.stamp) if stamped else 0
        self._on_command(twist.linear.x, twist.angular.z, stamp)

    def _run(self) -> None:
        try:
            while not self._closing.is_set():
                self._executor.spin_once()
        finally:
            if not self._closing.is_set():
                self._on_failure()


def driver_type(node: Node) -> type | None:
    """
    Return the message type in which a driver takes a node's `cmd_vel`; None: no driver does.

    A driver is a node that publishes its mode; the subscription may be that of its NAME_cmd_vel.
    Others may listen, too, such as a recorder.
    """
    drivers = {
        (each.node_namespace, each.node_name)
        for topic, types in node.get_topic_names_and_types() if MODE_TYPE in types
        for each in node.get_publishers_info_by_topic(topic) if each.node_name != UNNAMED}
    for each in node.get_subscriptions_info_by_topic(CMD_VEL):
        owner = each.node_namespace, each.node_name.removesuffix(f'_{CMD_VEL}')
        if owner in drivers and each.topic_type in COMMANDS:
            return COMMANDS[each.topic_type]
    return None


class VelocityOutput:
    """
    Publishes velocity commands, once a driver has been found.

    The publisher is made with the first command, and ends when none has followed for a while: a
    driver chooses its message type by its publishers, so one that is not used must not count.
    """

    def __init__(self, node: Node) -> None:
        """Use this node; nothing is published before a driver is found."""
        self._node = node
        self._publisher: Publisher | None = None
        self._type: type | None = None
        self._next_check = -inf
        self._unused = 0
        """Checks since the last command."""
        self.driver_listens = False
        """Whether a driver takes velocity commands."""

    def find_driver(self, now: float) -> None:
        """Check now and then which type the driver takes."""
        if now < self._next_check:
            return
        type_ = driver_type(self._node)
        self.driver_listens = type_ is not None
        self._next_check = now + (CHECK_INTERVAL if self.driver_listens else SEARCH_INTERVAL)
        self._unused += 1
        changed = type_ not in (None, self._type)
        if self._publisher is not None and (changed or self._unused > UNUSED_CHECKS):
            self._node.destroy_publisher(self._publisher)
            self._publisher = None
        self._type = type_ or self._type

    def publish(self, linear: float, angular: float) -> None:
        """Publish a velocity, m/s and rad/s, if a driver has been found."""
        if self._type is None:
            return
        if self._publisher is None:
            self._publisher = self._node.create_publisher(self._type, CMD_VEL, 1)
        self._unused = 0
        twist = Twist(linear=Vector3(x=linear), angular=Vector3(z=angular))
        if self._type is Twist:
            self._publisher.publish(twist)
        else:
            stamped = TwistStamped(twist=twist)
            stamped.header.stamp = self._node.get_clock().now().to_msg()
            self._publisher.publish(stamped)

    def stop(self) -> None:
        """Command a standstill, and wait until the command has arrived."""
        self.publish(0.0, 0.0)
        if self._publisher is not None:
            self._publisher.wait_for_all_acked(STOP_TIMEOUT)
