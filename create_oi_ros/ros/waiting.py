# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a program says while it waits for a driver: for whom, in which ROS domain, and who runs where.

ROS finds nothing in other domains. So each driver binds a Unix socket, whose abstract name has
its user, its domain and its node; Linux lists these names in /proc/net/unix, and frees one when
its process ends, however it ends.
"""

from collections.abc import Callable
import os
from pathlib import Path
import pwd
import re
import socket
import sys
import time
from typing import NamedTuple

from create_oi_msgs.msg import Mode
import rclpy
from rclpy.node import Node

from .topics import CMD_VEL, LATCHED, type_name
from .velocity import driver_type

WARNING_DELAY = 2.0
"""Seconds after which a program says that it waits."""
DISCOVERY_TIMEOUT = 10.0
"""Seconds in which ROS finds a driver that runs, on a busy computer."""
POLL_INTERVAL = 0.1
"""Seconds between two checks of what is awaited."""
MAX_NAME_LENGTH = 107
"""Bytes that Linux allows for the name of a socket."""
LISTED = re.compile(r'@create_oi_ros/driver/(\d+)/[\d.]+/(\d+)(/\S+)$', re.MULTILINE)
"""A driver's socket in the list: its user, its process, its ROS domain, its node."""
TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'
"""Variable of Fast DDS; UDPv4 on one side leaves out shared memory, which is for one user."""


class RunningDriver(NamedTuple):
    """A driver that runs on this computer."""

    domain: int
    name: str
    """Full name of its node."""
    user: int


def announce(domain: int, node: str) -> socket.socket:
    """Let programs of this computer know of a driver, by its full name, until it is closed."""
    announced = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    name = (f'\0create_oi_ros/driver/{os.getuid()}/{os.getpid()}.{announced.fileno()}/'
            f'{domain}{node}')
    announced.bind(name.encode()[:MAX_NAME_LENGTH])
    return announced


def drivers() -> list[RunningDriver]:
    """Return the drivers that run on this computer, sorted."""
    listed = Path('/proc/net/unix').read_text()
    return sorted({RunningDriver(int(domain), name, int(user))
                   for user, domain, name in LISTED.findall(listed)})


def _drivers_of(node: Node) -> list[RunningDriver]:
    """Return the drivers that run in the domain and namespace of a node."""
    domain, namespace = node.context.get_domain_id(), node.get_namespace().rstrip('/')
    return [each for each in drivers()
            if each.domain == domain and each.name.rpartition('/')[0] == namespace]


def other_user(node: Node) -> str | None:
    """Say that a node's driver runs as another user, and what to do; None: it does not."""
    users = {each.user for each in _drivers_of(node)}
    if not users or os.getuid() in users or os.environ.get(TRANSPORTS):
        return None
    return (f'the driver runs as user {_user_name(users.pop())} and this program as '
            f'{_user_name(os.getuid())}, but ROS passes no messages between two users: start both '
            f'as the same user, or `export {TRANSPORTS}=UDPv4` in this shell')


def _user_name(user: int) -> str:
    try:
        return pwd.getpwuid(user).pw_name
    except KeyError:  # in a container
        return str(user)


def waits_for(node: Node, what: str, waited: float) -> str | None:
    """Say what a node has waited for, s, and why it may not come; None: it may still come."""
    if waited < WARNING_DELAY:
        return None
    own, namespace = node.context.get_domain_id(), node.get_namespace()
    if (why := other_user(node)) is not None:
        return f'waits for {what} in ROS domain {own}: {why}'
    if _drivers_of(node):
        return None if waited < DISCOVERY_TIMEOUT else (
            f'waits for {what} in ROS domain {own}: a driver runs there, but ROS does not find '
            'it: is ROS_AUTOMATIC_DISCOVERY_RANGE or RMW_IMPLEMENTATION different there?')
    where = [_where(each, own) for each in drivers()]
    return (f'waits for {what} in ROS domain {own}'
            + (f', namespace {namespace}' if namespace != '/' else '') + '; on this computer '
            + (', '.join(where) if where else 'no driver runs: start one with create_run'))


def _where(driver: RunningDriver, own: int) -> str:
    domain, namespace = driver.domain, driver.name.rpartition('/')[0]
    reach = ([f'export ROS_DOMAIN_ID={domain}'] if domain != own else []) + (
        [f'--ros-args -r __ns:={namespace or "/"}'] if domain == own or namespace else [])
    return f'{driver.name} runs in domain {domain} ({", ".join(reach)})'


def say_if_waiting(node: Node, what: str, waits: Callable[[], bool],
                   say: Callable[[str], object]) -> None:
    """Have a node say once that it waits in vain, while its executor runs."""
    began = time.monotonic()

    def look() -> None:
        why = waits_for(node, what, time.monotonic() - began) if waits() else None
        if why is not None:
            say(why)
        if why is not None or not waits():
            node.destroy_timer(timer)
    timer = node.create_timer(POLL_INTERVAL, look)


def _commands_wait(node: Node) -> str | None:
    """Say why no driver takes the velocities of a node; None: one does, or it publishes none."""
    for publisher in node.publishers:
        if publisher.topic_name == node.resolve_topic_name(CMD_VEL):
            taken, ours = driver_type(node), publisher.msg_type
            if taken is None:
                return f'waits for a driver that takes {publisher.topic_name}'
            if taken is not ours:
                return (f'waits: the driver takes {type_name(taken)} from {publisher.topic_name}, '
                        f'and this program publishes {type_name(ours)}: let it publish the other, '
                        'or start the driver with cmd_vel_type: auto')
    return None


def wait_for_robot(node: Node, until: Callable[[], object] = lambda: True) -> None:
    """
    Spin until a driver has a robot and takes the velocities that the node publishes, if it does.

    `until` is something else to wait for, such as that a topic is heard. After 2 s say on stderr
    what is missing: the driver, a robot that answers, or the type of the commands.
    """
    heard: list[Mode] = []
    modes = node.create_subscription(Mode, 'mode', heard.append, LATCHED)
    began, said = time.monotonic(), None
    while True:
        commands = _commands_wait(node)
        if heard and heard[-1].mode != Mode.UNKNOWN and commands is None and until():
            break
        rclpy.spin_once(node, timeout_sec=POLL_INTERVAL)
        waited = time.monotonic() - began
        if not heard:
            why = waits_for(node, 'a driver', waited)
        elif waited < WARNING_DELAY:
            continue
        elif heard[-1].mode == Mode.UNKNOWN:
            why = f'waits for a robot ({heard[-1].reason}): is it switched on, and the cable in?'
        else:
            why = commands
        if why is not None and why != said:
            print(f'{node.get_name()}: {why}', file=sys.stderr, flush=True)
            said = why
    node.destroy_subscription(modes)
