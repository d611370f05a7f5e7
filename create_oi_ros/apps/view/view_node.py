"""The ROS node of the view: subscriptions, velocity commands, service calls."""

from __future__ import annotations

from contextlib import suppress
from math import inf
import time
from typing import Any

from create_oi_msgs.msg import CargoBay
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
from rclpy.action.client import ActionClient, ClientGoalHandle
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.task import Future
from sensor_msgs.msg import JointState

from ...ros import topics
from ...ros.actions import ACTIONS
from ...ros.services import SERVICES
from .keys import BINDINGS, GoalCall, ServiceCall, STOP
from .robot_state import CallStatus, RobotState
from .teleop import STANDSTILL, Velocity

CMD_VEL = 'cmd_vel'
COMMANDS = {f'geometry_msgs/msg/{type_.__name__}': type_ for type_ in (Twist, TwistStamped)}
CHECK_INTERVAL, SEARCH_INTERVAL = 1.0, 0.2
"""Seconds between two checks of who subscribes to cmd_vel, with a driver and without."""
SPIN_TIME = 0.05
"""Seconds for which callbacks run at most before the next picture."""
HEARD = tuple(topic for topic in topics.PUBLISHED if topic not in (topics.TF, topics.CONTACTS))
"""Topics to subscribe to; /tf repeats `odom`, and `contacts` the sensors."""
FAST = (Odometry, JointState, CargoBay)
"""Message types that come faster than anybody can read: only the newest is kept."""
NEWEST = QoSProfile(depth=1)
STOP_TIMEOUT = Duration(seconds=1.0)
"""How long to wait until the last command has arrived."""
LINK, PARAMETERS = 'serial link', 'parameters'
"""Names of two statuses in the driver's diagnostics."""
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
        self._velocity: Publisher | None = None
        self._commands: Subscription | None = None
        self._next_check = -inf

    def _set_periods(self, sensor_period: float) -> None:
        self.state.periods = {
            topic.type: (topic.name, period_of(topic, sensor_period)) for topic in HEARD}

    def _on_message(self, message: Any) -> None:
        self.state.update(message, time.monotonic())

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """Store the diagnostics of the driver in our namespace; other nodes use the topic too."""
        for status in message.status:
            node, _, about = status.name.rpartition(': ')
            if about == LINK and node.rpartition('/')[0] == self._own_namespace:
                self._on_message(message)
                self._read_statuses(node, message)

    def _read_statuses(self, node: str, message: DiagnosticArray) -> None:
        prefix = f'{node}: '
        self.state.diagnostics = {
            status.name.removeprefix(prefix): status
            for status in message.status if status.name.startswith(prefix)}
        if PARAMETERS in self.state.diagnostics:
            status = self.state.diagnostics[PARAMETERS]
            self.state.title = f'create_view  /{node}  {status.message}'
            rate = {value.key: value.value for value in status.values}.get('sensor_rate', '')
            with suppress(ValueError, ZeroDivisionError):  # a driver of another version
                self._set_periods(1 / float(rate))

    # Driving.

    def find_driver(self, now: float) -> None:
        """Check now and then who subscribes to cmd_vel, and publish in the type of the driver."""
        if now < self._next_check:
            return
        types = [
            COMMANDS[each.topic_type] for each in self.get_subscriptions_info_by_topic(CMD_VEL)
            # Another view subscribes too, but does not drive.
            if each.node_name != self.get_name() and each.topic_type in COMMANDS]
        self.state.driver_listens = bool(types)
        self._next_check = now + (CHECK_INTERVAL if types else SEARCH_INTERVAL)
        self.state.driver_count = self.count_publishers(topics.ODOM.name)
        if types and (self._velocity is None or self._velocity.msg_type is not types[0]):
            if self._velocity is not None and self._commands is not None:
                self.destroy_publisher(self._velocity)
                self.destroy_subscription(self._commands)
            self._velocity = self.create_publisher(types[0], CMD_VEL, NEWEST)
            self._commands = self.create_subscription(
                types[0], CMD_VEL, self._on_message, NEWEST)

    def drive(self, velocity: Velocity) -> None:
        """Publish a velocity command, if a driver has been found."""
        if self._velocity is None:
            return
        twist = Twist(linear=Vector3(x=velocity.linear), angular=Vector3(z=velocity.angular))
        if self._velocity.msg_type is Twist:
            self._velocity.publish(twist)
        else:
            stamped = TwistStamped(twist=twist)
            stamped.header.stamp = self.get_clock().now().to_msg()
            self._velocity.publish(stamped)

    def stop_robot(self) -> None:
        """Command a standstill, and wait until the command has arrived."""
        self.drive(STANDSTILL)
        if self._velocity is not None:
            self._velocity.wait_for_all_acked(STOP_TIMEOUT)

    # Services.

    def call_service(self, call: ServiceCall, now: float) -> None:
        """Call a service; the result appears in the state."""
        client = self._service_clients[call.service]
        if not client.service_is_ready():
            self.state.call_status = CallStatus(
                f'nobody offers {client.srv_name}: no driver is running', highlighted=True)
            return
        self.state.call_status = CallStatus(call.service, waiting_since=now)
        future = client.call_async(TYPES[call.service].Request(**call.fields))
        future.add_done_callback(lambda done: self._on_reply(call, done))

    def _on_reply(self, call: ServiceCall, done: Future) -> None:
        reply = done.result()
        text = ', '.join(filter(None, ('done' if reply.success else 'refused', reply.message)))
        self.state.call_status = CallStatus(
            f'{call.service}: {text}', highlighted=not reply.success)
        if reply.success and call.service == 'reset_odometry':
            self.state.trail.clear()

    # Goals.

    def send_goal(self, call: GoalCall, now: float) -> None:
        """Send a goal; the result appears in the state."""
        client = self._action_clients[call.name]
        if not client.server_is_ready():
            self.state.call_status = CallStatus(
                f'nobody offers {call.name}: no driver is running', highlighted=True)
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
            lambda done: self._on_result(call, done.result().result))

    def _on_result(self, call: GoalCall, result: Any) -> None:
        text = ', '.join(filter(None, ('done' if result.success else 'ended', result.message)))
        self.state.call_status = CallStatus(
            f'{call.name}: {text}', highlighted=not result.success)


def spin_ready(executor: SingleThreadedExecutor) -> None:
    """Run the callbacks that are ready, without waiting for more."""
    until = time.monotonic() + SPIN_TIME
    while time.monotonic() < until:
        try:
            callback, _, _ = executor.wait_for_ready_callbacks(timeout_sec=0.0)
        except TimeoutException:
            return
        callback()
        callback.result()
