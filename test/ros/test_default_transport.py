# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The node with the middleware as users have it: over shared memory, where all others use UDP."""

import signal

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import SetMode
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry


def test_the_node_drives_answers_and_ends_over_shared_memory(default_transport, stage):
    robot = stage.robot()
    node = stage.node(robot.link)
    odom = stage.ros.listen(Odometry, 'odom')
    velocity = stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)

    def drives():
        velocity.publish(Twist(linear=Vector3(x=0.2)))
        return odom and odom[-1].twist.twist.linear.x > 0.1
    stage.ros.until(drives)
    assert default_transport(stage.domain), 'no shared memory is in use'
    assert stage.ros.call(SetMode, 'set_mode', mode=Mode.FULL).success
    node.send(signal.SIGINT)
    assert node.ended() == 0
    assert robot.create.actuators.wheels == (0, 0)
