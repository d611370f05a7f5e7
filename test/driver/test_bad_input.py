# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Whatever is asked for: a clear refusal or a legal effect, and the driver lives.

What is tried comes from the definitions of messages, services and parameters themselves, so a
new field is covered without being remembered.
"""

from contextlib import contextmanager
from dataclasses import fields
from types import SimpleNamespace

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
import rclpy
from rclpy.parameter import Parameter
from rclpy.task import Future

from create_oi_ros import oi
from create_oi_ros.driver import Driver, Settings
from create_oi_ros.driver.goals import Code
from create_oi_ros.driver.outbox import WAKE_UP
from create_oi_ros.ros.actions import ACTIONS
from create_oi_ros.ros.node import CreateNode
from create_oi_ros.ros.odometry_model import ModelKeeper
from create_oi_ros.ros.parameters import declare, Parameters
from create_oi_ros.ros.services import serve, SERVICES
from support.anything import anything
from support.loop import Loop
from support.nightly import UNMEASURED
from support.ros import own_domain

pytestmark = UNMEASURED

PATIENCE = 3.0
"""Seconds of the robot within which every service answers."""
HARMLESS = (oi.Stream, oi.PauseResumeStream)
"""What the driver may say though a request was refused."""
STOPPED = oi.DriveDirect(right=0, left=0)
AWAY = {'reset_odometry', 'reset_pose'}
"""Services that do their work though no robot answers."""


class Desk:
    """The services in front of a robot in memory."""

    def __init__(self, state: str = 'safe') -> None:
        """`state`: the robot is in this mode, or `away`."""
        mode = oi.Mode.PASSIVE if state == 'passive' else oi.Mode.SAFE
        self.loop = Loop(Settings(mode_on_start=mode))
        self.loop.run(0.5)
        if state == 'away':
            self.loop.cut = True
            self.loop.run(1.0)
        assert (self.loop.driver.state.answered) == (state != 'away')
        self.loop.heard.clear()
        self._node = SimpleNamespace(get_logger=lambda: None, executor=None)
        self._model = ModelKeeper(self._node, '')

    @contextmanager
    def request(self):
        """Stand in for `Session.request`."""
        yield self.loop.driver, self.loop.now
        self.loop.turn()

    def call(self, service, request):
        """Return the reply, or fail when none comes."""
        answer = serve(
            self._node, self, self._model, service, request, service.type.Response())
        until = self.loop.now + PATIENCE
        while self.loop.now < until:
            try:
                answer.send(None)
            except StopIteration as end:
                return end.value
            self.loop.turn()
        raise AssertionError(f'{service.name} does not answer')

    def state(self):
        """Return what a refused request must leave as it is."""
        robot = self.loop.robot
        return (robot.mode, robot.demo, robot.lights, robot.outputs, robot.actuators.wheels,
                self.loop.body.truth().pose, dict(self.loop.driver.songs.defined))


def legal_commands(heard: bytes) -> list[oi.Command]:
    """Return what the robot was told; fail when the manual does not allow it."""
    reader, commands, told = oi.CommandReader(), [], bytes(heard)
    reader.feed(told)
    while (event := reader.next_event()) is not None:
        assert isinstance(event, oi.Command), f'{event} in {told!r}'
        event.encode()
        commands.append(event)
    assert not reader.pending
    return commands


@pytest.mark.parametrize('service', SERVICES, ids=lambda each: each.name)
@settings(max_examples=12)
@given(st.data())
def test_a_service_refuses_clearly_or_does_what_is_legal(service, data):
    state = data.draw(st.sampled_from(['safe', 'passive', 'away']))
    request = data.draw(anything(service.type.Request))
    desk = Desk(state)
    before = desk.state()
    reply = desk.call(service, request)
    assert reply.success or reply.message
    if state != 'away':
        commands = legal_commands(desk.loop.heard)
        desk.loop.run(0.1)
        if not reply.success and service.name != 'stop':
            told = [each for each in commands if not isinstance(each, HARMLESS)]
            entered = {oi.Start, oi.Safe, oi.Full} if service.name == 'set_mode' else set()
            assert all(each == STOPPED or type(each) in entered for each in told)
            assert desk.state() == before
    else:
        assert not reply.success or service.name in AWAY


@pytest.fixture(scope='module')
def node():
    """Return a real node in a domain of its own, to whose callbacks messages are handed."""
    with own_domain() as domain:
        rclpy.init(args=[], domain_id=domain)
        made = CreateNode(Future())
        yield made
        made.stop()
        made.destroy_node()
        rclpy.shutdown()


@pytest.mark.parametrize('action', [
    each for each in ACTIONS if each.name != 'audio_note_sequence'], ids=lambda each: each.name)
@settings(max_examples=8)
@given(st.data())
def test_a_goal_is_malformed_in_words_or_pursued_by_legal_commands(action, data):
    request, desk = data.draw(anything(action.type.Goal)), Desk()
    goals = desk.loop.driver.goals
    try:
        goal = action.make(request)
    except ValueError as why:
        assert 'allowed: ' in str(why) or 'is not finite' in str(why)
        return
    running = goals.start(goal, desk.loop.now)
    desk.loop.run(0.5)
    goals.cancel(running, desk.loop.now)
    desk.loop.run(0.1)
    legal_commands(desk.loop.heard)
    assert running.code in (Code.NONE, Code.TIMEOUT, Code.NO_DOCK, Code.CANCELED)
    assert desk.loop.robot.actuators.wheels == (0, 0)


# Parameters.


def good_values(declared) -> list:
    """Return values of a parameter that are allowed, its limits among them."""
    facts, default = declared.metadata, declared.default
    if facts['choices']:
        return list(facts['choices'])
    if isinstance(default, bool):
        return [True, False]
    if not isinstance(default, float):
        return [default]
    whole = [1] if facts['low'] <= 1 <= facts['high'] else []
    return [default, facts['low'], facts['high'], *whole]


each_parameter = pytest.mark.parametrize('declared', fields(Parameters), ids=lambda it: it.name)


GOES_WITH = {'battery_low': {'battery_empty': 0.0}, 'battery_empty': {'battery_low': 20.0}}
"""Other values that a value needs, so that they do not contradict each other."""


@contextmanager
def started_with(name, value):
    """Make a plain node that was given a parameter on its command line, and what goes with it."""
    given = {**GOES_WITH.get(name, {}), name: value}
    made = rclpy.create_node(
        'start', parameter_overrides=[
            Parameter(each, value=worth) for each, worth in given.items()],
        start_parameter_services=False, enable_rosout=False,
        automatically_declare_parameters_from_overrides=True)
    try:
        yield made
    finally:
        made.destroy_node()


@each_parameter
def test_a_parameter_within_its_range_is_taken_at_start_and_works(node, declared):
    for value in good_values(declared):
        with started_with(declared.name, value) as starting:
            parameters = declare(starting)
        taken = getattr(parameters, declared.name)
        assert (taken, type(taken)) == (value, type(declared.default))
        loop = Loop(parameters.settings())
        loop.run(0.3)
        loop.drive(0.2, 1.0, 0.2)
        legal_commands(loop.heard.replace(WAKE_UP, b''))


@each_parameter
def test_a_parameter_is_set_at_run_time_or_is_for_the_start_only(node, declared):
    before = getattr(node.parameters, declared.name)
    for value in good_values(declared):
        result, = node.set_parameters([Parameter(declared.name, value=value)])
        assert result.successful == declared.metadata['live']
        assert result.successful or result.reason
        if result.successful:
            assert getattr(node.parameters, declared.name) == value
            assert node.get_parameter(declared.name).value == value
    node.set_parameters([Parameter(declared.name, value=before)])


def test_the_driver_has_no_setting_that_no_parameter_reaches():
    assert Driver(Parameters().settings()).settings == Settings()
