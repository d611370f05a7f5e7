# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The services: each a row with the function that hands its request to the driver.

Clients do not block each other: a service is a coroutine, which the executor resumes when the
driver knows the outcome.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from create_oi_msgs import srv
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from std_srvs.srv import Trigger

from .. import oi
from ..driver import Driver, Outcome, Pending
from ..driver.outbox import refused
from ..link.session import Session
from ..oi.tools.text import parse_script
from . import messages
from .messages import Values, yaw_of
from .odometry_model import ModelKeeper

QUEUE = QoSProfile(depth=200)
"""Requests that may arrive at once; more than the depth are never answered (ROS default: 10)."""

LONGEST = 1000
"""Characters of a text for people; its end says what is allowed."""


def define_song(driver: Driver, request: srv.DefineSong.Request, now: float) -> Pending:
    song = request.number, list(request.pitches), list(request.seconds)
    return (driver.songs.define_and_play(*song, now) if request.play
            else driver.songs.define(*song))


def set_digital_outputs(
    driver: Driver, request: srv.SetDigitalOutputs.Request, _now: float,
) -> Pending:
    outputs = request.output_0, request.output_1, request.output_2
    return driver.outputs.set_outputs(
        oi.OutputBits(sum(bit for bit, high in zip(oi.OutputBits, outputs) if high)))


def define_script(driver: Driver, request: srv.DefineScript.Request, _now: float) -> Pending:
    if request.text and request.code:
        return refused('both text and code are given: leave one empty')
    try:
        script = (parse_script(request.text) if request.text
                  else oi.Script(script=bytes(request.code)))
    except ValueError as error:
        return refused(str(error))
    return driver.scripts.define(script)


def shortened(text: str) -> str:
    """Return a text for people without the middle of a megabyte that it may repeat."""
    return text if len(text) <= LONGEST else f'{text[:LONGEST // 2]} ... {text[-LONGEST // 2:]}'


def answer(outcome: Outcome) -> Values:
    """Return how a request ended, as fields of a response."""
    return {'success': outcome.ok, 'message': shortened(outcome.text)}


@dataclass(frozen=True, kw_only=True)
class Service:
    """One service."""

    name: str
    type: type
    about: str
    request: Callable[[Driver, Any, float], Pending] | None
    """Hands a request to the driver, with the time, s; None: it is not for the driver."""


SERVICES = (
    Service(
        name='set_mode', type=srv.SetMode,
        request=lambda driver, request, now: driver.modes.set(request.mode, now),
        about='enter Passive (1), Safe (2) or Full (3); answers when the robot reports it'),
    Service(
        name='stop', type=Trigger, request=lambda driver, _, now: driver.stop(now),
        about='stop the wheels, and a demo, before anything else is sent'),
    Service(
        name='reset_odometry', type=Trigger,
        request=lambda driver, _, now: driver.reset_odometry(),
        about='begin `odom` again where the robot is'),
    Service(
        name='reset_pose', type=srv.ResetPose,
        request=lambda driver, request, _: driver.reset_pose(
            request.pose.position.x, request.pose.position.y, yaw_of(request.pose.orientation)),
        about='say where the robot is in `odom_frame`: `odom` goes on from there'),
    Service(
        name='save_odometry_model', type=Trigger, request=None,
        about='write what the odometry has learned of the robot to `odometry_model`'),
    Service(
        name='define_song', type=srv.DefineSong, request=define_song,
        about='store a song as MIDI numbers and seconds, and play it if `play` is set'),
    Service(
        name='play_song', type=srv.PlaySong,
        request=lambda driver, request, now: driver.songs.play(request.number, now),
        about='play a song that was stored'),
    Service(
        name='set_leds', type=srv.SetLeds,
        request=lambda driver, request, _: driver.outputs.set_leds(messages.leds(request)),
        about='Play and Advance; colour and intensity of Power'),
    Service(
        name='set_digital_outputs', type=srv.SetDigitalOutputs, request=set_digital_outputs,
        about='the three digital outputs of the cargo bay'),
    Service(
        name='set_digital_output', type=srv.SetDigitalOutput,
        request=lambda driver, request, _: driver.outputs.set_output(
            request.output, high=request.high),
        about='one of them, by its name in `output_names`; the others stay'),
    Service(
        name='set_low_side_drivers', type=srv.SetLowSideDrivers,
        request=lambda driver, request, _: driver.outputs.set_drivers(
            (request.driver_0, request.driver_1, request.driver_2)),
        about='duty cycles of the three low side drivers, 0.0 (off) to 1.0 (on)'),
    Service(
        name='send_ir', type=srv.SendIr,
        request=lambda driver, request, _: driver.outputs.send_ir(request.character),
        about='send an infrared character by low side driver 1'),
    Service(
        name='start_demo', type=srv.StartDemo,
        request=lambda driver, request, _: driver.modes.start_demo(request.demo),
        about='let the robot play a built-in demo, 0 (Cover) to 9 (Banjo); the action '
        '`dock` also says how 1 (Cover and Dock) ends'),
    Service(
        name='stop_demo', type=Trigger, request=lambda driver, _, now: driver.modes.stop_demo(),
        about='end the demo; the robot stays in Passive'),
    Service(
        name='define_script', type=srv.DefineScript, request=define_script,
        about='store a script, as lines of text or as bytes'),
    Service(
        name='play_script', type=srv.PlayScript,
        request=lambda driver, request, now: driver.scripts.play(now, force=request.force),
        about='play the stored script; one that cannot end only by `force`'),
)
"""All services."""
SERVICE_TYPES: dict[str, Any] = {service.name: service.type for service in SERVICES}


def offer(node: Node, session: Session, model: ModelKeeper) -> None:
    """Offer all services."""
    # A service that waits for the robot must not keep the other callbacks from running.
    group = ReentrantCallbackGroup()
    for service in SERVICES:
        node.create_service(
            service.type, service.name, partial(serve, node, session, model, service),
            qos_profile=QUEUE, callback_group=group)


async def serve(node: Node, session: Session, model: ModelKeeper, service: Service,
                request: Any, response: Any) -> Any:
    """Hand a request to the driver, and return the response when it has ended."""
    if service.request is None:
        outcome = model.save(session)
    else:
        with session.request() as (driver, now):
            ended = future_of(service.request(driver, request, now), node)
        outcome = await ended
    return type(response)(**answer(outcome))


def future_of(pending: Pending, node: Node) -> Future:
    """Return a future of an outcome; the thread that brings it wakes the node."""
    ended = Future()

    def end(outcome: Outcome) -> None:
        ended.set_result(outcome)
        if node.executor is not None:
            node.executor.wake()
    pending.then(end)
    return ended
