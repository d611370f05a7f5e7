"""The two ends of the view in the ROS graph: what it hears, and what it says."""

from __future__ import annotations

from contextlib import suppress
from math import inf
import time
from typing import Any

from create_oi_msgs.msg import CargoBay
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.task import Future
from sensor_msgs.msg import JointState

from ...ros import topics
from ...ros.services import SERVICES
from .keys import Ask, BINDINGS, STOP
from .robot_state import Note, State
from .teleop import STANDSTILL, Velocity

CMD_VEL = 'cmd_vel'
COMMANDS = {f'geometry_msgs/msg/{type_.__name__}': type_ for type_ in (Twist, TwistStamped)}
LOOK_AROUND, LOOK_AGAIN = 1.0, 0.2
"""Seconds between two looks at who listens to velocity commands: when somebody does, and not."""
MOST_WORK = 0.05
"""Seconds for which messages are taken in before the screen has its turn."""
HEARD = tuple(topic for topic in topics.PUBLISHED if topic is not topics.TF)
FAST = (Odometry, JointState, CargoBay)
LAST_WORD = Duration(seconds=1.0)
NEWEST = QoSProfile(depth=1)
"""For what comes faster than anybody can read: older ones need not be taken."""
LINK, PARAMETERS = 'serial link', 'parameters'
"""What the driver calls two of its diagnostics."""
TYPES: dict[str, Any] = {service.name: service.type for service in SERVICES}


def period_of(topic: topics.Topic, sensors: float = 0.0) -> float:
    """Return the seconds after which a topic comes again; inf: not before it changes."""
    if isinstance(topic, topics.SensorTopic):
        return sensors if topic.period is None else topic.period
    return {topics.MODE.name: inf, topics.DIAGNOSTICS.name: 1.0}.get(topic.name, 0.0)


class Graph(Node):
    """Fills a state with what is heard, drives, and calls services."""

    def __init__(self, state: State) -> None:
        """Subscribe to what the driver publishes; its transform says no more than `odom`."""
        super().__init__('create_view', start_parameter_services=False, enable_rosout=False)
        self.state = state
        self._home = self.get_namespace().strip('/')
        domain = self.context.get_domain_id()
        state.title = f'create_view  namespace {self.get_namespace()}  ROS domain {domain}'
        self._expect(0.0)
        for topic in HEARD:
            heard = self._on_diagnostics if topic is topics.DIAGNOSTICS else self._on_message
            qos = NEWEST if topic.type in FAST else topic.qos
            self.create_subscription(topic.type, topic.name, heard, qos)
        # A client needs a moment to be known, so it is made before it is wanted.
        self._callers = {
            name: self.create_client(TYPES[name], name)
            for name in {each.action.service for each in BINDINGS if isinstance(each.action, Ask)}
            | {STOP.service}}
        self._velocity: Publisher | None = None
        self._commands: Subscription | None = None
        self._next_look = -inf

    def _expect(self, sensors: float) -> None:
        self.state.periods = {
            topic.type: (topic.name, period_of(topic, sensors)) for topic in HEARD}

    def _on_message(self, message: Any) -> None:
        self.state.take(message, time.monotonic())

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """Take in what the driver of this namespace says; others use the topic as well."""
        for status in message.status:
            node, _, about = status.name.rpartition(': ')
            if about == LINK and node.rpartition('/')[0] == self._home:
                self._on_message(message)
                self._diagnosed(node, message)

    def _diagnosed(self, node: str, message: DiagnosticArray) -> None:
        prefix = f'{node}: '
        self.state.diagnostics = {
            status.name.removeprefix(prefix): status
            for status in message.status if status.name.startswith(prefix)}
        if PARAMETERS in self.state.diagnostics:
            known = self.state.diagnostics[PARAMETERS]
            self.state.title = f'create_view  /{node}  {known.message}'
            rate = {value.key: value.value for value in known.values}.get('sensor_rate', '')
            with suppress(ValueError, ZeroDivisionError):  # another version may not tell it
                self._expect(1 / float(rate))

    # Driving.

    def look_around(self, now: float) -> None:
        """Find out, now and then, as what type velocity commands are wanted."""
        if now < self._next_look:
            return
        wanted = [
            COMMANDS[each.topic_type] for each in self.get_subscriptions_info_by_topic(CMD_VEL)
            # Another view listens as well, and proves nothing.
            if each.node_name != self.get_name() and each.topic_type in COMMANDS]
        self.state.listened = bool(wanted)
        self._next_look = now + (LOOK_AROUND if wanted else LOOK_AGAIN)
        self.state.drivers = self.count_publishers(topics.ODOM.name)
        if wanted and (self._velocity is None or self._velocity.msg_type is not wanted[0]):
            if self._velocity is not None and self._commands is not None:
                self.destroy_publisher(self._velocity)
                self.destroy_subscription(self._commands)
            self._velocity = self.create_publisher(wanted[0], CMD_VEL, NEWEST)
            self._commands = self.create_subscription(
                wanted[0], CMD_VEL, self._on_message, NEWEST)

    def drive(self, velocity: Velocity) -> None:
        """Command a velocity, if somebody listens."""
        if self._velocity is None:
            return
        twist = Twist(linear=Vector3(x=velocity.linear), angular=Vector3(z=velocity.angular))
        if self._velocity.msg_type is Twist:
            self._velocity.publish(twist)
        else:
            stamped = TwistStamped(twist=twist)
            stamped.header.stamp = self.get_clock().now().to_msg()
            self._velocity.publish(stamped)

    def say_goodbye(self) -> None:
        """Stop the robot, and see that this arrives."""
        self.drive(STANDSTILL)
        if self._velocity is not None:
            self._velocity.wait_for_all_acked(LAST_WORD)

    # Services.

    def ask(self, ask: Ask, now: float) -> None:
        """Call a service; the state tells how that went."""
        caller = self._callers[ask.service]
        if not caller.service_is_ready():
            self.state.note = Note(
                f'nobody offers {caller.srv_name}: no driver is running', loud=True)
            return
        self.state.note = Note(ask.service, waiting_since=now)
        future = caller.call_async(TYPES[ask.service].Request(**ask.fields))
        future.add_done_callback(lambda done: self._answered(ask, done))

    def _answered(self, ask: Ask, done: Future) -> None:
        reply = done.result()
        text = ', '.join(filter(None, ('done' if reply.success else 'refused', reply.message)))
        self.state.note = Note(f'{ask.service}: {text}', loud=not reply.success)
        if reply.success and ask.service == 'reset_odometry':
            self.state.track.clear()


def take_in(executor: SingleThreadedExecutor) -> None:
    """Run the callbacks that are due, without waiting for any."""
    until = time.monotonic() + MOST_WORK
    while time.monotonic() < until:
        try:
            callback, _, _ = executor.wait_for_ready_callbacks(timeout_sec=0.0)
        except TimeoutException:
            return
        callback()
        callback.result()
