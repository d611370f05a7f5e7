# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The ROS node of the view: subscriptions, velocity commands, service calls."""

from __future__ import annotations

from contextlib import suppress
from math import inf
import time
from typing import Any

from create_oi_msgs.msg import CargoBay
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.action.client import ActionClient, ClientGoalHandle
from rclpy.node import Node
from rclpy.subscription import Subscription
from rclpy.task import Future
from sensor_msgs.msg import JointState

from ...driver.motion import Velocity
from ...ros import topics
from ...ros.actions import ACTIONS
from ...ros.diagnostics import of_driver, PARAMETERS
from ...ros.services import SERVICES
from ...ros.velocity_output import NEWEST, VelocityOutput
from .keys import BINDINGS, GoalCall, ServiceCall, STOP
from .robot_state import CallStatus, RobotState

HEARD = tuple(topic for topic in topics.PUBLISHED if topic not in (topics.TF, topics.CONTACTS))
"""Topics to subscribe to; /tf repeats `odom`, and `contacts` the sensors."""
FAST = (Odometry, JointState, CargoBay)
"""Message types that come faster than anybody can read: only the newest is kept."""
TYPES: dict[str, Any] = {service.name: service.type for service in SERVICES}
ACTION_TYPES: dict[str, Any] = {action.name: action.type for action in ACTIONS}


def period_of(topic: topics.Topic, sensor_period: float = 0.0) -> float:
    """Return the seconds between two messages of a topic; inf: published on change only."""
    if isinstance(topic, topics.SensorTopic):
        return sensor_period if topic.period is None else topic.period
    return {topics.MODE.name: inf, topics.DIAGNOSTICS.name: 1.0}.get(topic.name, 0.0)


class ViewNode(Node):
    """Stores what it receives in a state, publishes velocity commands, calls services."""

    def __init__(self, state: RobotState) -> None:
        """Subscribe to the driver's topics and create clients for the services of the keys."""
        super().__init__('create_view', start_parameter_services=False, enable_rosout=False)
        self.state = state
        self._own_namespace = self.get_namespace().strip('/')
        domain = self.context.get_domain_id()
        state.title = f'create_view  namespace {self.get_namespace()}  ROS domain {domain}'
        self._set_periods(0.0)
        for topic in HEARD:
            callback = self._on_diagnostics if topic is topics.DIAGNOSTICS else self._on_message
            qos = NEWEST if topic.type in FAST else topic.qos
            self.create_subscription(topic.type, topic.name, callback, qos)
        # Discovery takes a moment, so the clients are created before they are needed.
        calls = [each.action for each in BINDINGS if isinstance(each.action, ServiceCall)]
        self._service_clients = {
            name: self.create_client(TYPES[name], name)
            for name in {call.service for call in (*calls, STOP)}}
        goals = {each.action.name for each in BINDINGS if isinstance(each.action, GoalCall)}
        self._action_clients = {
            name: ActionClient(self, ACTION_TYPES[name], name) for name in goals}
        self._velocity = VelocityOutput(self)
        self._commands: Subscription | None = None
        self._heard_type: type | None = None

    def _set_periods(self, sensor_period: float) -> None:
        self.state.periods = {
            topic.type: (topic.name, period_of(topic, sensor_period)) for topic in HEARD}

    def _on_message(self, message: Any) -> None:
        self.state.update(message, time.monotonic())

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """Store the diagnostics of the driver in our namespace, and what its parameters say."""
        found = of_driver(message, self._own_namespace)
        if found is None:
            return
        self._on_message(message)
        node, self.state.diagnostics = found
        status = self.state.diagnostics.get(PARAMETERS)
        if status is not None:
            self.state.title = f'create_view  /{node}  {status.message}'
            rate = {value.key: value.value for value in status.values}.get('sensor_rate', '')
            with suppress(ValueError, ZeroDivisionError):  # a driver of another version
                self._set_periods(1 / float(rate))

    # Driving.

    def find_driver(self, now: float) -> None:
        """Check now and then who subscribes to cmd_vel, and publish in the type of the driver."""
        if not self._velocity.find_driver(now):
            return
        self.state.driver_listens = self._velocity.driver_listens
        self.state.driver_count = self.count_publishers(topics.ODOM.name)
        if self._velocity.type is not None and self._velocity.type is not self._heard_type:
            if self._commands is not None:
                self.destroy_subscription(self._commands)
            self._heard_type = self._velocity.type
            self._commands = self.create_subscription(
                self._heard_type, topics.CMD_VEL, self._on_message, NEWEST)

    def drive(self, velocity: Velocity) -> None:
        """Publish a velocity command, if a driver has been found."""
        self._velocity.publish(*velocity)

    def stop_robot(self) -> None:
        """Command a standstill, and wait until the command has arrived."""
        self._velocity.stop()

    # Services.

    def call_service(self, call: ServiceCall, now: float) -> None:
        """Call a service; the result appears in the state."""
        client = self._service_clients[call.service]
        if not client.service_is_ready():
            self._show_missing(client.srv_name)
            return
        self.state.call_status = CallStatus(call.service, waiting_since=now)
        future = client.call_async(TYPES[call.service].Request(**call.fields))
        future.add_done_callback(lambda done: self._on_reply(call, done))

    def _on_reply(self, call: ServiceCall, done: Future) -> None:
        reply = done.result()
        self._show_end(call.service, reply, 'refused')
        if reply.success and call.service == 'reset_odometry':
            self.state.trail.clear()

    # Goals.

    def send_goal(self, call: GoalCall, now: float) -> None:
        """Send a goal; the result appears in the state."""
        client = self._action_clients[call.name]
        if not client.server_is_ready():
            self._show_missing(call.name)
            return
        self.state.call_status = CallStatus(call.name, waiting_since=now)
        sent = client.send_goal_async(ACTION_TYPES[call.name].Goal(**call.fields))
        sent.add_done_callback(lambda done: self._on_answer(call, done.result()))

    def _on_answer(self, call: GoalCall, handle: ClientGoalHandle) -> None:
        if not handle.accepted:
            self.state.call_status = CallStatus(
                f'{call.name}: rejected, the log of the driver says why', highlighted=True)
            return
        self.state.call_status = CallStatus(f'{call.name}: under way; space stops it')
        handle.get_result_async().add_done_callback(
            lambda done: self._show_end(call.name, done.result().result, failed=''))

    # What the user is told of both.

    def _show_missing(self, name: str) -> None:
        self.state.call_status = CallStatus(
            f'nobody offers {name}: no driver is running', highlighted=True)

    def _show_end(self, name: str, answer: Any, failed: str) -> None:
        """Show a reply or a result; `failed` is the word for one without success."""
        text = ', '.join(filter(None, ('done' if answer.success else failed, answer.message)))
        self.state.call_status = CallStatus(f'{name}: {text}', highlighted=not answer.success)
