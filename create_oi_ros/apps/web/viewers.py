# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The ROS node of the page, and the connected pages: what each has been told, and what it may do.

All pages are told how the newest goal fares, and each can cancel it.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Coroutine
from itertools import count
import json
from math import isfinite
import time
from typing import Any

from aiohttp import web, WSCloseCode, WSMsgType
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from ...robot import BODY_RADIUS, TOP_SPEED, WHEEL_SEPARATION
from ...ros.collector import subscribe
from ...ros.driver_client import DriverClient, Goal, GoalState, Reply
from ...ros.topics import CMD_VEL
from ...ros.velocity import VelocityOutput
from .access import (
    BURST,
    CALLS,
    checked,
    DriverSeat,
    LONGEST_MESSAGE,
    MOST_VIEWERS,
    OLDEST_VIEW,
    RATE,
    read,
    Refused,
    TOP_TURN,
)
from .bag_recording import BagRecording
from .live_robot import Cursor, LiveRobot, PARTS

HOLD = 0.15
"""Seconds that a command to drive holds."""
STOP_TIMEOUT = 0.3
"""Seconds in which the driver should have done a stop."""
HEARTBEAT = 5.0
"""Seconds between two pings; a page that does not answer is disconnected."""
MOST_REPLIES = 50
"""Replies that wait to be sent to one page; older ones are dropped."""
TUNE = 'audio_note_sequence'
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""For `odom`: the page is told twenty times a second."""


class WebNode(Node):
    """Passes messages to a live robot; has what publishes velocities and calls the driver."""

    def __init__(self) -> None:
        """Subscribe to the driver's topics and create clients for the services."""
        super().__init__('create_web', start_parameter_services=False, enable_rosout=False)
        self.velocity = VelocityOutput(self)
        self.robot = LiveRobot(self.get_namespace())
        subscribe(self, PARTS, lambda name, message: self.robot.update(
            name, message, time.monotonic()), odom=NEWEST)
        self.driver = DriverClient(self)
        for name in CALLS:  # discovery takes a moment: before they are needed
            self.driver.client(name)


def feedback_part(feedback: Any) -> dict[str, Any]:
    """Return a feedback as JSON can say it; a number that is none is left out."""
    found = {name: getattr(feedback, name) for name in feedback.get_fields_and_field_types()}
    return {name: round(value, 3) if isinstance(value, float) else value
            for name, value in found.items()
            if isinstance(value, str) or (isinstance(value, int | float) and isfinite(value))}


class NewestGoal:
    """The newest goal of a kind: all pages are shown it, and can cancel it."""

    def __init__(self, node: WebNode, part: str) -> None:
        """Show it as a part of the node's robot."""
        self._node, self._part = node, part
        self._goal: Goal | None = None
        self._viewer = 0

    def begin(self, viewer: int, name: str, goal: Any) -> Awaitable[Reply]:
        """Begin a goal at once, so that STOP finds it; return what waits for its end."""
        self._viewer = viewer
        self._goal = Goal(self._node.driver, name, goal, self._show)
        self._show(self._goal)
        return self._goal.pursue()

    def _show(self, goal: Goal) -> None:
        text = '' if goal.reply is None else goal.reply.text
        if goal.reply is not None:
            self._node.robot.happened(
                'error' if goal.state is GoalState.FAILED else '',
                f'{goal.name.replace("_", " ")}: {text}', time.monotonic())
        if goal is self._goal:
            runs = goal.state is GoalState.UNDER_WAY and goal.feedback is not None
            self._node.robot.parts.put(self._part, {
                'name': goal.name, 'viewer': self._viewer, 'state': goal.state.value,
                'text': text, 'feedback': feedback_part(goal.feedback) if runs else None})

    def cancel(self, but: int | None = None) -> bool:
        """Cancel the goal that runs, if it is not of a viewer; return whether there is one."""
        if self._goal is None or self._goal.reply is not None or self._viewer == but:
            return False
        self._goal.cancel()
        return True


class Viewer:
    """One connected page."""

    def __init__(self, number: int, socket: web.WebSocketResponse, request: web.Request) -> None:
        self.number, self.socket = number, socket
        self.page = request.query.get('page')
        """A name that a page gives itself, so that it is known when it connects again."""
        agent = request.headers.get('User-Agent', '')
        tablet = 'iPad' in agent or ('Android' in agent and 'Mobile' not in agent)
        self.device = 'tablet' if tablet else 'phone' if 'Mobi' in agent else 'computer'
        self._budget, self._at = BURST, time.monotonic()
        """Messages that it may send at once, and when that was so."""
        self.cursor = Cursor()
        self.replies: deque[str] = deque(maxlen=MOST_REPLIES)
        self.news = asyncio.Event()
        """Set when there may be something to send."""

    def sends_too_much(self) -> bool:
        """Count a message; return whether it is more than RATE and BURST allow."""
        now = time.monotonic()
        self._budget = min(BURST, self._budget + (now - self._at) * RATE) - 1
        self._at = now
        return self._budget < 0

    def reply(self, to: str, ok: bool, text: str) -> None:
        """Queue a reply to a message of this page."""
        self.replies.append(json.dumps({'type': 'reply', 'to': to, 'ok': ok, 'text': text}))
        self.news.set()


class Viewers:
    """Serves all pages; everything here runs on the event loop's thread."""

    def __init__(self, node: WebNode, recording: BagRecording) -> None:
        self._node, self._robot, self._recording = node, node.robot, recording
        self._viewers: dict[int, Viewer] = {}
        self._tasks: set[asyncio.Task[object]] = set()
        self._seat = DriverSeat()
        self._goals = {each: NewestGoal(node, each) for each in ('goal', 'tune')}
        """Those that move the robot, and tunes, which play beside them."""
        self._expiry: asyncio.TimerHandle | None = None
        self._numbers = count(1)
        self._update_seat()

    def __len__(self) -> int:
        """Return how many pages are connected."""
        return len(self._viewers)

    async def serve(self, request: web.Request) -> web.WebSocketResponse:
        """Serve one page until it goes."""
        socket = web.WebSocketResponse(
            max_msg_size=LONGEST_MESSAGE, heartbeat=HEARTBEAT, compress=False, timeout=1.0)
        await socket.prepare(request)
        for before in list(self._viewers.values()):
            if before.page is not None and before.page == request.query.get('page'):
                self._leave(before)  # its connection is dead, and only we do not know
                self._keep(before.socket.close())
        if len(self._viewers) >= MOST_VIEWERS:
            await socket.close(code=WSCloseCode.TRY_AGAIN_LATER,
                               message=f'{MOST_VIEWERS} pages are open already'.encode())
            return socket
        viewer = Viewer(next(self._numbers), socket, request)
        self._viewers[viewer.number] = viewer
        self._update_seat()
        sender = asyncio.create_task(self._send(viewer))
        try:
            await self._receive(viewer)
        finally:
            sender.cancel()
            self._leave(viewer)
        return socket

    def _leave(self, viewer: Viewer) -> None:
        if self._viewers.pop(viewer.number, None) is not None:
            self._brake_if(self._seat.leave(viewer.number))
            self._update_seat()

    async def close(self) -> None:
        """Stop the wheels if a page drives, cancel its goal, and disconnect all pages."""
        for each in self._goals.values():
            each.cancel()
        if self._seat.driving:
            self._node.velocity.stop()
        for viewer in list(self._viewers.values()):
            await viewer.socket.close(code=WSCloseCode.GOING_AWAY, message=b'the server ends')

    def tell(self) -> None:
        """Send what is new to all pages; one that is still being sent something is left out."""
        for viewer in self._viewers.values():
            viewer.news.set()

    async def _send(self, viewer: Viewer) -> None:
        try:
            await viewer.socket.send_json({
                'type': 'hello', 'you': viewer.number, 'top_speed': TOP_SPEED,
                'top_turn': TOP_TURN, 'oldest_view': OLDEST_VIEW, 'radius': BODY_RADIUS,
                'separation': WHEEL_SEPARATION})
            while True:
                await viewer.news.wait()
                viewer.news.clear()
                while viewer.replies:
                    await viewer.socket.send_str(viewer.replies.popleft())
                text, viewer.cursor = self._robot.news(viewer.cursor, time.monotonic())
                await viewer.socket.send_str(text)
        except ConnectionError:  # the page has gone: `_receive` ends, too
            return

    async def _receive(self, viewer: Viewer) -> None:
        async for message in viewer.socket:
            if viewer.sends_too_much():
                await viewer.socket.close(code=WSCloseCode.POLICY_VIOLATION,
                                          message=b'too many messages')
                return
            if message.type is not WSMsgType.TEXT:
                viewer.reply('', False, 'allowed is text: a JSON object')
                continue
            self._take(viewer, message.data)

    def _take(self, viewer: Viewer, text: str) -> None:
        """Do what a page asks for, or tell it why not."""
        type_ = ''
        try:
            type_, fields = read(text)
            self._obey(viewer, type_, checked(type_, fields))
        except Refused as refusal:
            viewer.reply(type_, False, str(refusal))

    def _obey(self, viewer: Viewer, type_: str, content: Any) -> None:
        """Do what a page asks for; Refused says why not."""
        number = viewer.number
        match type_:
            case 'ping':
                viewer.reply(type_, True, '')
            case 'record':
                self._recording.switch(**content)
            case 'drive':
                self._drive(number, **content)
            case 'release':
                self._stop_if(self._seat.release(number))
            case 'leave':
                self._stop_if(self._seat.leave(number))
            case 'take_over':
                self._stop_if(self._seat.take_over(number))
            case 'cancel':
                if not self._goals[content['what']].cancel():
                    raise Refused(f'no {content["what"]} of a page is under way')
            case 'stop':
                self._seat.stop()
                self._stop_if(True)
                for each in self._goals.values():
                    each.cancel()
                self._robot.happened('warn', 'STOP was pressed', time.monotonic())
                self._keep(self._pass_on(viewer, type_, self._call(type_, content)))
            case _ if type_ in CALLS:
                self._seat.sit(number)
                self._keep(self._pass_on(viewer, type_, self._call(type_, content)))
            case _:
                self._seat.sit(number)
                goal = self._goals['tune' if type_ == TUNE else 'goal']
                begun = goal.begin(number, type_, content)
                self._keep(self._pass_on(viewer, type_, begun))
        self._update_seat()

    def _drive(self, number: int, linear: float, angular: float, seen: float) -> None:
        if not self._node.velocity.driver_listens:
            topic = self._node.resolve_topic_name(CMD_VEL)
            raise Refused(f'no driver takes {topic}: start one with create_run')
        if self._seat.drive(number, time.monotonic() - seen):
            self._node.velocity.publish(float(linear), float(angular))
            if self._expiry is not None:
                self._expiry.cancel()
            self._expiry = asyncio.get_running_loop().call_later(
                HOLD, lambda: self._brake_if(self._seat.expire()))

    def _stop_if(self, due: bool) -> None:
        if due:
            self._node.velocity.publish(0.0, 0.0)

    def _brake_if(self, due: bool) -> None:
        """Stop the wheels at once, beyond all limits: whoever drove sees them no more."""
        if due:
            self._keep(self._brake())

    async def _brake(self) -> None:
        """Send a stop; a zero, which is followed gently, only where it is not done in time."""
        stop = asyncio.create_task(self._node.driver.call('stop', Trigger.Request()))
        await asyncio.wait([stop], timeout=STOP_TIMEOUT)
        done = stop.done() and stop.result().ok
        self._stop_if(not done and not self._seat.driving)
        await stop

    def _update_seat(self) -> None:
        """Cancel goals of viewers that may not drive any more, and show who may."""
        for each in self._goals.values():
            each.cancel(but=self._seat.viewer)
        driver = self._viewers.get(self._seat.viewer or 0)
        self._robot.parts.put('seat', {
            'driver': self._seat.viewer, 'device': driver.device if driver else '',
            'viewers': len(self), 'stopped': self._seat.latched})

    # Services and goals.

    async def _call(self, name: str, request: Any) -> Reply:
        reply = await self._node.driver.call(name, request)
        if reply.ok and name == 'reset_odometry':
            self._robot.forget()
        return reply

    async def _pass_on(self, viewer: Viewer, to: str, reply: Awaitable[Reply]) -> None:
        """Wait for a reply, and pass it on."""
        ok, text, _ = await reply
        viewer.reply(to, ok, text)

    def _keep(self, work: Coroutine[Any, Any, object]) -> None:
        """Let something run to its end in the background."""
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
