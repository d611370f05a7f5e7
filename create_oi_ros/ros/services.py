# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The services: each declared beside the method that serves it.

A method checks the request, hands it to the driver, and waits for the outcome. Clients do not
block each other: a service is a coroutine, which the executor resumes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from create_oi_msgs.srv import (
    DefineScript,
    DefineSong,
    PlayScript,
    PlaySong,
    SendIr,
    SetDigitalOutputs,
    SetLeds,
    SetLowSideDrivers,
    SetMode,
    ShowScript,
    StartDemo,
)
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from std_srvs.srv import Trigger

from .. import oi
from ..driver import Outcome, Pending
from ..driver.outbox import Awaited
from ..link.session import Session
from . import messages
from .model_keeper import ModelKeeper

QUEUE = QoSProfile(depth=200)
"""Requests that may arrive at once; more than the depth are never answered (ROS default: 10)."""
MODES = ', '.join(f'{mode.value} {mode.name}' for mode in oi.Mode)
DEMOS = ', '.join(f'{demo.value} {demo.name}' for demo in oi.DemoNumber if demo >= 0)


@dataclass(frozen=True, kw_only=True)
class Service:
    """One service; `Services` has a method of the same name."""

    name: str
    type: type
    about: str


SERVICES: list[Service] = []
"""All services, in the order of their methods."""
Method = TypeVar('Method', bound=Callable[..., Any])


def service(type_: type, about: str) -> Callable[[Method], Method]:
    """Declare a method as the service of its name."""
    def declare(method: Method) -> Method:
        SERVICES.append(Service(name=method.__name__, type=type_, about=about))
        return method
    return declare


class Services:
    """The callbacks of all services."""

    def __init__(self, node: Node, session: Session, model: ModelKeeper) -> None:
        """Offer all services."""
        self._node = node
        self._session = session
        self._model = model
        # A service that waits for the robot must not keep the other callbacks from running.
        group = ReentrantCallbackGroup()
        for each in SERVICES:
            node.create_service(each.type, each.name, getattr(self, each.name),
                                qos_profile=QUEUE, callback_group=group)

    def _ended(self, pending: Pending) -> Future:
        """Return a future of the outcome."""
        return future_of(pending, self._node)

    @service(SetMode, 'enter Passive (1), Safe (2) or Full (3); answers when the robot reports it')
    async def set_mode(
        self, request: SetMode.Request, response: SetMode.Response,
    ) -> SetMode.Response:
        """Enter a mode."""
        if request.mode not in list(oi.Mode):
            return refuse(response, f'mode {request.mode} is none of {MODES}')
        with self._session.request() as (driver, now):
            ended = self._ended(driver.set_mode(oi.Mode(request.mode), now))
        return fill(response, await ended)

    @service(Trigger, 'stop the wheels, and a demo, before anything else is sent')
    async def stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Stop the wheels at once."""
        with self._session.request() as (driver, now):
            ended = self._ended(driver.stop(now))
        return fill(response, await ended)

    @service(Trigger, 'begin `odom` again where the robot is')
    async def reset_odometry(
        self, _: Trigger.Request, response: Trigger.Response,
    ) -> Trigger.Response:
        """Begin the odometry again."""
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.reset_odometry())
        return fill(response, await ended)

    @service(Trigger, 'write what the odometry has learned of the robot to `odometry_model`')
    async def save_odometry_model(
        self, _: Trigger.Request, response: Trigger.Response,
    ) -> Trigger.Response:
        """Write what is known of the robot."""
        return fill(response, self._model.save(self._session))

    @service(DefineSong, 'store a song as MIDI numbers and seconds, and play it if `play` is set')
    async def define_song(
        self, request: DefineSong.Request, response: DefineSong.Response,
    ) -> DefineSong.Response:
        """Store a song, and play it if asked to."""
        song = request.number, list(request.pitches), list(request.seconds)
        with self._session.request() as (driver, now):
            ended = self._ended(driver.outputs.define_and_play(*song, now) if request.play
                                else driver.outputs.define_song(*song))
        return fill(response, await ended)

    @service(PlaySong, 'play a song that was stored')
    async def play_song(
        self, request: PlaySong.Request, response: PlaySong.Response,
    ) -> PlaySong.Response:
        """Play a song."""
        with self._session.request() as (driver, now):
            ended = self._ended(driver.outputs.play_song(request.number, now))
        return fill(response, await ended)

    @service(SetLeds, 'Play and Advance; colour and intensity of Power')
    async def set_leds(
        self, request: SetLeds.Request, response: SetLeds.Response,
    ) -> SetLeds.Response:
        """Set the LEDs."""
        bits = messages.led_bits(request.play, request.advance)
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.outputs.set_leds(
                bits, request.power_color, request.power_intensity))
        return fill(response, await ended)

    @service(SetDigitalOutputs, 'the three digital outputs of the cargo bay')
    async def set_digital_outputs(
        self, request: SetDigitalOutputs.Request, response: SetDigitalOutputs.Response,
    ) -> SetDigitalOutputs.Response:
        """Set the digital outputs."""
        bits = messages.output_bits(request.output_0, request.output_1, request.output_2)
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.outputs.set_outputs(bits))
        return fill(response, await ended)

    @service(SetLowSideDrivers,
             'duty cycles of the three low side drivers, 0.0 (off) to 1.0 (on)')
    async def set_low_side_drivers(
        self, request: SetLowSideDrivers.Request, response: SetLowSideDrivers.Response,
    ) -> SetLowSideDrivers.Response:
        """Set the low side drivers."""
        duties = (request.driver_0, request.driver_1, request.driver_2)
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.outputs.set_drivers(duties))
        return fill(response, await ended)

    @service(SendIr, 'send an infrared character by low side driver 1')
    async def send_ir(
        self, request: SendIr.Request, response: SendIr.Response,
    ) -> SendIr.Response:
        """Send an infrared character."""
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.outputs.send_ir(request.character))
        return fill(response, await ended)

    @service(StartDemo, 'let the robot play a built-in demo, 0 (Cover) to 9 (Banjo)')
    async def start_demo(
        self, request: StartDemo.Request, response: StartDemo.Response,
    ) -> StartDemo.Response:
        """Start a demo."""
        if request.demo not in list(oi.DemoNumber):
            return refuse(response, f'demo {request.demo} is none of {DEMOS}')
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.demos.start(oi.DemoNumber(request.demo)))
        return fill(response, await ended)

    @service(Trigger, 'end the demo; the robot stays in Passive')
    async def stop_demo(
        self, _: Trigger.Request, response: Trigger.Response,
    ) -> Trigger.Response:
        """End a demo."""
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.demos.stop())
        return fill(response, await ended)

    @service(Trigger, 'start the demo that looks for the Home Base, and answer at once; the '
             'action `dock` also says how it ends')
    async def dock(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Look for the Home Base."""
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.demos.start(oi.DemoNumber.COVER_AND_DOCK))
        return fill(response, await ended)

    @service(DefineScript, 'store a script, as lines of text or as bytes')
    async def define_script(
        self, request: DefineScript.Request, response: DefineScript.Response,
    ) -> DefineScript.Response:
        """Store a script."""
        try:
            script = messages.script(request.text, bytes(request.code))
        except ValueError as error:
            return refuse(response, str(error))
        with self._session.request() as (driver, _now):
            ended = self._ended(driver.scripts.define(script))
        return fill(response, await ended)

    @service(PlayScript, 'play the stored script; one that cannot end only by `force`')
    async def play_script(
        self, request: PlayScript.Request, response: PlayScript.Response,
    ) -> PlayScript.Response:
        """Play the stored script."""
        with self._session.request() as (driver, now):
            ended = self._ended(driver.scripts.play(now, force=request.force))
        return fill(response, await ended)

    @service(ShowScript, 'read the stored script back')
    async def show_script(
        self, _: ShowScript.Request, response: ShowScript.Response,
    ) -> ShowScript.Response:
        """Read the stored script back."""
        with self._session.request() as (driver, now):
            ended = self._ended(driver.scripts.show(now))
        outcome = await ended
        response.code = outcome.payload
        response.text = messages.script_text(outcome.payload)
        return fill(response, outcome)


def fill(response: Any, outcome: Outcome) -> Any:
    """Put how a request ended into a response."""
    response.success, response.message = outcome.ok, outcome.text
    return response


def refuse(response: Any, why: str) -> Any:
    """Refuse a request that never reaches the driver."""
    return fill(response, Outcome(False, why))


Result = TypeVar('Result')


def future_of(awaited: Awaited[Result], node: Node) -> Future:
    """Return a future of a result; the thread that brings it wakes the node."""
    ended = Future()

    def end(result: Result) -> None:
        ended.set_result(result)
        if node.executor is not None:
            node.executor.wake()
    awaited.then(end)
    return ended
