"""
What is published with every frame: one message a topic, made once and filled again.

A topic that nobody listens to costs a look at the number of its subscribers. Latched topics are
published all the same, for those who come later.
"""

from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from sensor_msgs.msg import JointState

from . import convert, topics
from .odometry import Estimate
from .oi import Readings
from .parameters import Parameters
from .topics import Edge, SensorTopic, Topic


def publisher(node: Node, topic: Topic) -> Publisher:
    """Declare a topic to ROS."""
    return node.create_publisher(topic.type, topic.name, topic.qos)


class MotionPublisher:
    """Tells where the robot is and how it moves: `odom`, `/tf` and `joint_states`."""

    def __init__(self, node: Node, parameters: Parameters, stamp: Time) -> None:
        """Declare the topics; all messages share the stamp."""
        header = convert.header(parameters.odom_frame, stamp)
        self._odometry: Odometry = convert.odometry_message(header, parameters.base_frame)
        self._transform = TransformStamped(header=header, child_frame_id=parameters.base_frame)
        self._transforms = topics.TF.type(transforms=[self._transform])
        self._joints: JointState = convert.joint_states_message(convert.header('', stamp))
        self._odom = publisher(node, topics.ODOM)
        self._tf = publisher(node, topics.TF) if parameters.publish_tf else None
        self._joint_states = publisher(node, topics.JOINT_STATES)

    def publish(self, estimate: Estimate) -> None:
        """Publish an estimate."""
        if self._odom.get_subscription_count():
            convert.odometry(self._odometry, estimate)
            self._odom.publish(self._odometry)
        if self._tf is not None and self._tf.get_subscription_count():
            convert.transform(self._transform, estimate)
            self._tf.publish(self._transforms)
        if self._joint_states.get_subscription_count():
            convert.joint_states(self._joints, estimate)
            self._joint_states.publish(self._joints)


class SensorPublisher:
    """Tells of one sensor: at once when it changes, and now and then when it does not."""

    def __init__(self, node: Node, topic: SensorTopic, frame: str, stamp: Time) -> None:
        """Declare the topic."""
        self._topic, self._edge = topic, Edge(topic)
        self._latched = topic.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        self._publisher = publisher(node, topic)
        self._message: Any = topic.type(header=convert.header(frame, stamp))

    def publish(self, readings: Readings, when: float, sensor_period: float) -> None:
        """Publish the readings of a frame at `when` seconds, if they are due."""
        if not self._edge.due(readings, when, sensor_period):
            return
        if self._latched or self._publisher.get_subscription_count():
            self._topic.fill(self._message, readings)
            self._publisher.publish(self._message)
