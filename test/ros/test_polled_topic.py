# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A subscription without an executor: its messages are taken by whoever looks."""

from contextlib import closing

from rclpy.qos import QoSProfile
from std_msgs.msg import Int32

from create_oi_ros.ros.polled_topic import PolledTopic
from support.ros import Listener, own_domain


def test_a_polled_topic_passes_on_what_has_come_and_no_more_than_it_keeps():
    with own_domain() as domain, closing(Listener(domain)) as ros:
        taken: list[int] = []
        polled = PolledTopic(
            ros.node, Int32, 'number', lambda message: taken.append(message.data),
            QoSProfile(depth=3))
        heard = ros.listen(Int32, 'number')
        publisher = ros.node.create_publisher(Int32, 'number', 10)
        polled.take()
        assert taken == []
        for number in range(5):
            publisher.publish(Int32(data=number))
        ros.until(lambda: len(heard) == 5)
        assert taken == [], 'the executor leaves them alone'
        polled.take()
        assert taken == [2, 3, 4]
        polled.take()
        assert taken == [2, 3, 4]
