# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the driver's process, and commands that end."""

from collections.abc import Callable
from random import Random
import signal
import time

from geometry_msgs.msg import Twist
from std_srvs.srv import Trigger

from create_oi_ros.ros.programs import PROGRAMS
from nightly.fault import (
    Fault,
    recovered,
    Result,
    start_driving,
    Try,
)
from nightly.stage import Stage

RAISING = """
from create_oi_ros.ros import messages, programs
def fail(*_):
    raise RuntimeError('a fault on purpose')
bumper = messages.bumper
messages.bumper = lambda readings: (
    fail() if readings.bumps_and_wheel_drops else bumper(readings))
from create_oi_ros.ros.velocity_input import VelocityInput
take = VelocityInput._take
VelocityInput._take = lambda commands, message, info: (
    fail() if message.linear.z else take(commands, message, info))
raise SystemExit(programs.create_node())
"""
"""A node whose bumper message and velocity callback can raise an exception."""


def ending(end: Callable[[Stage], None], exit_code: int, program: str) -> Try:
    """Return a try in which the node ends while the wheels turn."""
    def attempt(stage: Stage, random: Random) -> Result:
        stage.start_node(code=program, cmd_vel_timeout='10.0')
        start_driving(stage, random)
        begun = time.monotonic()
        end(stage)
        stage.control.truth('wait right=0 left=0 timeout=15')
        result = Result(zero=time.monotonic() - begun)
        ended = stage.node.ended()
        truth = stage.control.truth('wait speed<0.001 mode=PASSIVE')
        stage.control.tell('bump off', 'force bump_left=0 bump_right=0')
        if ended != exit_code:
            result.trouble = f'exit code {ended}, not {exit_code}'
        stage.control.tell('after 0.3')
        if stage.control.truth()['commands'] != truth['commands']:
            result.trouble = 'commands still arrive at the robot'
        return result
    return attempt


def killed(number: signal.Signals) -> Fault:
    """Return the fault that a signal kills the node at once."""
    return _ends(number.name, _send(number), 0.1, -number)


def ended(number: signal.Signals) -> Fault:
    """Return the fault that a signal asks the node to end."""
    return _ends(number.name, _send(number), 0.1, 0)


def raising(name: str, end: Callable[[Stage], None]) -> Fault:
    """Return the fault that a callback of the node raises an exception."""
    return _ends(name, end, 0.2, 1, RAISING)


def _send(number: signal.Signals) -> Callable[[Stage], None]:
    return lambda stage: stage.node.send(number)


def _ends(name: str, end: Callable[[Stage], None], zero: float, exit_code: int,
          program: str = PROGRAMS['create_node']) -> Fault:
    return Fault(
        name, ending(end, exit_code, program), keeps_node=False, recovery=None, zero=zero)


def publishing(twist: Twist) -> Callable[[Stage], None]:
    """Return a function that publishes one velocity."""
    return lambda stage: stage.publish(twist)


def suspended(stage: Stage, random: Random) -> Result:
    """Stop the node's process (SIGSTOP) as the wheels turn, and continue it (SIGCONT)."""
    start_driving(stage, random)
    begun = time.monotonic()
    stage.node.send(signal.SIGSTOP)
    stage.control.truth('wait right=0 left=0 timeout=15')
    result = Result(zero=time.monotonic() - begun)
    stage.wait(random.uniform(1.2, 3.0))
    stage.node.send(signal.SIGCONT)
    return recovered(stage, result)


def commands_end(stage: Stage, random: Random) -> Result:
    """Send no more velocities."""
    start_driving(stage, random)
    return Result(zero=stage.until(stage.stopped, 'a stop'))


def told_to_stop(stage: Stage, random: Random) -> Result:
    """Call the service `stop`."""
    client = stage.ros.node.create_client(Trigger, 'stop')
    stage.until(client.service_is_ready, 'the service')
    start_driving(stage, random)
    begun = time.monotonic()
    called = client.call_async(Trigger.Request())
    stage.control.truth('wait right=0 left=0')
    result = Result(zero=time.monotonic() - begun)
    stage.until(called.done, 'the reply')
    stage.ros.node.destroy_client(client)
    result.trouble = '' if called.result().success else called.result().message
    return result
