"""The services' answers: a request is checked and handed to the driver, its reply is awaited."""

from collections.abc import Callable
from typing import Any

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
from ..driver import Driver, Reply
from ..link.session import Session
from . import messages as convert
from .service_table import SERVICES

AT_ONCE = QoSProfile(depth=200)
"""So many requests may come at once; of ROS's own ten, those beyond are never answered."""
MODES = ', '.join(f'{mode.value} {mode.name}' for mode in oi.Mode)
DEMOS = ', '.join(f'{demo.value} {demo.name}' for demo in oi.DemoNumber if demo >= 0)

Asked = Callable[[Driver, float, Any], None]
"""Puts a request to the driver, with the time and the `Reply` or `ShowReply`."""


class Answers:
    """One method for each service of the table, by its name."""

    def __init__(self, node: Node, session: Session) -> None:
        """Offer all services."""
        self._node = node
        self._session = session
        # A service that waits for the robot must not keep the other callbacks from running.
        together = ReentrantCallbackGroup()
        for service in SERVICES:
            node.create_service(
                service.type, service.name, getattr(self, service.name),
                qos_profile=AT_ONCE, callback_group=together)

    async def _ask(self, response: Any, asked: Asked) -> Any:
        """Put a request to the driver; return the response when the reply has come."""
        answered = Future()

        def reply(*answer: Any) -> None:
            """Resume the service that waits, from whichever thread."""
            answered.set_result(answer)
            if self._node.executor is not None:
                self._node.executor.wake()
        with self._session.request() as (driver, now):
            asked(driver, now, reply)
        response.success, response.message, *more = await answered
        if more:
            response.code = more[0]
            response.text = convert.script_text(more[0])
        return response

    async def set_mode(
        self, request: SetMode.Request, response: SetMode.Response,
    ) -> SetMode.Response:
        """Enter a mode, and wait for the robot to report it."""
        if request.mode not in list(oi.Mode):
            response.message = f'mode {request.mode} is none of {MODES}'
            return response
        mode = oi.Mode(request.mode)
        return await self._ask(
            response, lambda driver, now, reply: driver.set_mode(mode, now, reply))

    def stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Stop the wheels at once."""
        with self._session.request() as (driver, now):
            response.success, response.message = driver.stop(now)
        return response

    def reset_odometry(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Begin the odometry again."""
        with self._session.request() as (driver, _now):
            driver.reset_odometry()
        response.success, response.message = True, 'odom starts again where the robot is'
        return response

    async def define_song(
        self, request: DefineSong.Request, response: DefineSong.Response,
    ) -> DefineSong.Response:
        """Store a song, and play it if asked to."""
        def asked(driver: Driver, _: float, reply: Reply) -> None:
            songs = driver.actuators
            define = songs.define_and_play if request.play else songs.define_song
            define(request.number, list(request.pitches), list(request.seconds), reply)
        return await self._ask(response, asked)

    async def play_song(
        self, request: PlaySong.Request, response: PlaySong.Response,
    ) -> PlaySong.Response:
        """Play a song."""
        return await self._ask(
            response,
            lambda driver, _, reply: driver.actuators.play_song(request.number, reply))

    async def set_leds(
        self, request: SetLeds.Request, response: SetLeds.Response,
    ) -> SetLeds.Response:
        """Set the LEDs."""
        bits = convert.led_bits(request.play, request.advance)
        return await self._ask(response, lambda driver, _, reply: driver.actuators.set_leds(
            bits, request.power_color, request.power_intensity, reply))

    async def set_digital_outputs(
        self, request: SetDigitalOutputs.Request, response: SetDigitalOutputs.Response,
    ) -> SetDigitalOutputs.Response:
        """Set the digital outputs."""
        bits = convert.output_bits(request.output_0, request.output_1, request.output_2)
        return await self._ask(
            response, lambda driver, _, reply: driver.actuators.set_outputs(bits, reply))

    async def set_low_side_drivers(
        self, request: SetLowSideDrivers.Request, response: SetLowSideDrivers.Response,
    ) -> SetLowSideDrivers.Response:
        """Set the low side drivers."""
        duties = (request.driver_0, request.driver_1, request.driver_2)
        return await self._ask(
            response, lambda driver, _, reply: driver.actuators.set_drivers(duties, reply))

    async def send_ir(
        self, request: SendIr.Request, response: SendIr.Response,
    ) -> SendIr.Response:
        """Send an infrared character."""
        return await self._ask(
            response, lambda driver, _, reply: driver.actuators.send_ir(request.character, reply))

    async def start_demo(
        self, request: StartDemo.Request, response: StartDemo.Response,
    ) -> StartDemo.Response:
        """Start a demo."""
        if request.demo not in list(oi.DemoNumber):
            response.message = f'demo {request.demo} is none of {DEMOS}'
            return response
        demo = oi.DemoNumber(request.demo)
        return await self._ask(
            response, lambda driver, _, reply: driver.demos.start(demo, reply))

    async def stop_demo(
        self, _: Trigger.Request, response: Trigger.Response,
    ) -> Trigger.Response:
        """End a demo."""
        return await self._ask(response, lambda driver, _, reply: driver.demos.stop(reply))

    async def dock(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Look for the Home Base."""
        return await self._ask(response, lambda driver, _, reply: driver.demos.start(
            oi.DemoNumber.COVER_AND_DOCK, reply))

    async def define_script(
        self, request: DefineScript.Request, response: DefineScript.Response,
    ) -> DefineScript.Response:
        """Store a script."""
        try:
            script = convert.script(request.text, bytes(request.code))
        except ValueError as error:
            response.message = str(error)
            return response
        return await self._ask(
            response, lambda driver, _, reply: driver.scripts.define(script, reply))

    async def play_script(
        self, request: PlayScript.Request, response: PlayScript.Response,
    ) -> PlayScript.Response:
        """Play the stored script."""
        return await self._ask(response, lambda driver, now, reply: driver.scripts.play(
            now, reply, force=request.force))

    async def show_script(
        self, _: ShowScript.Request, response: ShowScript.Response,
    ) -> ShowScript.Response:
        """Read the stored script back."""
        return await self._ask(
            response, lambda driver, now, reply: driver.scripts.show(now, reply))
