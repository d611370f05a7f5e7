# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The ROS node `create`: topics, services and parameters around a session with the robot."""

from contextlib import ExitStack
from dataclasses import asdict, replace
import sys
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from rclpy.time import Time
from std_msgs.msg import Header

from .. import __version__
from ..driver import Driver, DriverEvent, LinkCounts, ModeStatus, Moved, Notice, Severity
from ..link.capture import Capture
from ..link.session import Session
from ..oi.tools.capture_format import RecordKind
from . import diagnostics, messages, node_arguments, parameters, services, topics
from .actions import Actions
from .graph_watch import GraphWatch
from .odometry_model import ModelKeeper
from .process import call_on_signal, ros_executor, spin_ready, spin_until
from .publishing import CLOCK_WARNING_INTERVAL, FramePublisher, publisher
from .velocity import VelocityInput
from .waiting import announce


class CreateNode(Node):
    """Publishes what the robot senses, and passes commands to it."""

    def __init__(self, ended: Future, **options: Any) -> None:
        """
        Declare everything; ValueError or ParameterException: a parameter is wrong.

        `ended` gets the exit code when the node cannot go on; options are those of rclpy's Node.
        No port is opened yet.
        """
        try:
            super().__init__(
                'create', automatically_declare_parameters_from_overrides=True, **options)
        except ValueError as error:
            if 'PARAMETER_NOT_SET' not in str(error):
                raise
            raise ValueError('a parameter is an empty list, [], of which ROS cannot tell the '
                             'type: leave it out') from None
        self.parameters = parameters.declare(self)
        self.add_pre_set_parameters_callback(parameters.as_declared)
        self.add_on_set_parameters_callback(parameters.check)
        self.add_post_set_parameters_callback(self._parameters_changed)
        self.model = ModelKeeper(self, self.parameters.odometry_model)
        self.capture = self._start_capture()
        self._on_failure = lambda: ended.set_result(1)
        self.session = Session(
            Driver(replace(self.parameters.settings(), robot=self.model.robot)),
            self.parameters.port,
            on_event=self._on_event, on_failure=self._on_failure,
            dead_man=self.parameters.dead_man,
            record=self.capture.add if self.capture else None)
        self._stale = 0
        self._declare_topics()
        services.offer(self, self.session, self.model)
        self._actions = Actions(self, self.session, self.parameters, self._stamps)
        self._counts = LinkCounts()
        namespace = self.get_namespace()
        self._hardware_id = f'iRobot Create at {self.parameters.port}' + (
            f' ({namespace})' if namespace != '/' else '')
        self._timer = self.create_timer(  # it does not wait for a simulated clock
            1.0, self._watch_and_report, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._publish_mode(self.session.driver.status)
        self._announced = announce(
            self.context.get_domain_id(), self.get_fully_qualified_name())

    def _start_capture(self) -> Capture | None:
        """Start the capture that the parameters ask for; ValueError says why it cannot be."""
        wanted = self.parameters.capture
        if not wanted:
            return None
        facts = {'driver': f'create_oi_ros {__version__}', **asdict(self.parameters)}
        log = self.get_logger()
        try:
            capture = Capture(
                wanted, facts, lambda why: log.error(f'capture {wanted}: {why}'))
        except OSError as error:
            raise ValueError(
                f'parameter capture: {wanted} cannot be written: {error.strerror}') from error
        log.info(f'every byte of the line is written to {capture.path}')
        return capture

    def _declare_topics(self) -> None:
        self._frames = FramePublisher(self, self.parameters)
        self._stamps = self._frames.stamps
        self._mode_waits, self._seconds_without_time = False, 0
        self._mode = publisher(self, topics.MODE)
        self._diagnostics = publisher(self, topics.DIAGNOSTICS)
        self._commands = VelocityInput(
            self, self.parameters.cmd_vel_type, self._on_velocity, on_failure=self._on_failure)
        self._graph = GraphWatch(self, self._commands, self.parameters)

    def start(self) -> None:
        """Open the port, call the robot, and take commands."""
        self.session.start()
        self._commands.start()

    def stop(self) -> None:
        """Stop the robot, close the port, and write what was learned and captured."""
        with ExitStack() as ends:  # the last one first, and each whatever the others raise
            if self.capture is not None:
                ends.callback(self.capture.close)
            ends.callback(self._announced.close)
            ends.callback(self.model.end, self.session)
            ends.callback(self._commands.close)
            ends.callback(self.destroy_timer, self._timer)
            ends.callback(self.session.close)

    # From ROS to the robot: velocities on a thread of their own, the rest on the executor's.

    def _on_velocity(self, linear: float, angular: float, stamp: int) -> None:
        now, timeout = self._stamps.now(), self.parameters.cmd_vel_timeout
        age = (now - stamp) / messages.NANOSECONDS if stamp and now is not None else 0.0
        if age > timeout:
            self._stale += 1
            self.get_logger().warning(
                f'cmd_vel of {age:.1f} s ago is dropped: is the clock of its sender right?',
                throttle_duration_sec=CLOCK_WARNING_INTERVAL)
            return
        self.session.drive(linear, angular)
        if age < -timeout:
            self.get_logger().warning(
                f'cmd_vel is stamped {-age:.1f} s ahead of now: it is followed, and an old one '
                'would not be noticed: is the clock of its sender right?',
                throttle_duration_sec=CLOCK_WARNING_INTERVAL)

    def _parameters_changed(self, changed: list[Parameter]) -> None:
        self.parameters = replace(self.parameters, **{
            each.name: each.value for each in changed if each.name in parameters.DECLARED})
        with self.session.request() as (driver, _now):
            driver.set_limits(self.parameters.limits())

    # From the robot to ROS: on the session's thread.

    def _on_event(self, event: DriverEvent) -> None:
        match event:
            case Moved():
                self._frames.publish(event, self.parameters)
                self._actions.report()
            case ModeStatus():
                self._publish_mode(event)
            case Notice():
                self._log(event)

    def _publish_mode(self, status: ModeStatus) -> None:
        """Publish the mode with the stamp of the frame that told it; later if there is no time."""
        stamp = self._stamps.now() if status.actual is None else self._stamps.newest
        self._mode_waits = stamp is None
        if stamp is not None:
            header = Header(
                frame_id=self.parameters.base_frame, stamp=Time(nanoseconds=stamp).to_msg())
            self._mode.publish(messages.mode(status, header))

    def _watch_and_report(self) -> None:
        """Look for mistakes and lost clients, and publish diagnostics; called once a second."""
        other_driver_ended = self._graph.check()
        if other_driver_ended or self._mode_waits:
            with self.session.request() as (driver, _now):
                self._publish_mode(driver.status)
                if other_driver_ended:
                    self._frames.repeat()
        self._actions.check_clients()
        timeless = self._stamps.now() is None
        self._seconds_without_time = self._seconds_without_time + 1 if timeless else 0
        if self._seconds_without_time % CLOCK_WARNING_INTERVAL == 2:  # it may have to be found
            self.get_logger().warning(
                'use_sim_time is true, but no time comes on /clock: no topic is published, '
                'commands are followed. Start what publishes /clock, or leave use_sim_time out')
        if self._diagnostics.get_subscription_count() and not timeless:
            self._publish_diagnostics()
        else:
            self._counts = replace(self.session.driver.counts)

    def _publish_diagnostics(self) -> None:
        health = self.session.health()
        message = topics.DIAGNOSTICS.type(status=[
            diagnostics.serial_link(health, self.parameters.port, self._counts),
            diagnostics.mode(health), diagnostics.safety(health),
            diagnostics.battery(health, charge_known=self.parameters.charge_known),
            diagnostics.driver(health, self._stale, self._graph.publishers),
            diagnostics.odometry(health), diagnostics.parameters(self.parameters)])
        for status in message.status:
            status.name = f'{self.get_fully_qualified_name().lstrip("/")}: {status.name}'
            status.hardware_id = self._hardware_id
        self._counts = health.counts
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)

    def _log(self, notice: Notice) -> None:
        if self.capture is not None:
            severity = notice.severity.name.lower()
            self.capture.add(RecordKind.NOTE, f'{severity}: {notice.text}')
        match notice.severity:
            case Severity.INFO:
                self.get_logger().info(notice.text)
            case Severity.WARNING:
                self.get_logger().warning(notice.text)
            case Severity.ERROR:
                self.get_logger().error(notice.text)


def main() -> int:
    """
    Run the node until it is told to stop, or cannot go on.

    Return the exit code: 0 when told to, 1 when it failed, 2 when an argument is wrong.
    """
    node_arguments.parse(sys.argv[1:])
    ended = Future()
    call_on_signal(lambda: ended.set_result(0))
    with ros_executor() as executor:
        try:
            node = CreateNode(ended)
        except (ValueError, ParameterException) as error:
            print(f'create_node: {error}', file=sys.stderr)
            return 2
        executor.add_node(node)
        try:
            node.start()
            spin_until(executor, ended)
        finally:
            node.stop()
            for _ in range(2):  # a goal that ran gets its result, then that is sent
                spin_ready(executor)
    return int(ended.result())
