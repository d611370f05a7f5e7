# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What a program says while it waits for a driver: for whom, in which ROS domain, and who runs where.

ROS finds nothing in other domains. So each driver binds a Unix socket, whose abstract name has
its domain and its node; Linux lists these names in /proc/net/unix, and frees one when its process
ends, however it ends.
"""

from collections.abc import Callable
import os
from pathlib import Path
import re
import socket
import sys
import time

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
LISTED = re.compile(r'@create_oi_ros/driver/[\d.]+/(\d+)(/\S+)$', re.MULTILINE)
"""A driver's socket in the list: its process, its ROS domain, its node."""


def announce(domain: int, node: str) -> socket.socket:
    """Let programs of this computer know of a driver, by its full name, until it is closed."""
    announced = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    name = f'\0create_oi_ros/driver/{os.getpid()}.{announced.fileno()}/{domain}{node}'
    announced.bind(name.encode()[:MAX_NAME_LENGTH])
    return announced


def drivers() -> list[tuple[int, str]]:
    """Return ROS domain and full node name of the drivers that run on this computer."""
    listed = Path('/proc/net/unix').read_text()
    return sorted({(int(domain), name) for domain, name in LISTED.findall(listed)})


def waits_for(node: Node, what: str, waited: float) -> str | None:
    """Say what a node has waited for, s, and why it may not come; None: it may still come."""
    if waited < WARNING_DELAY:
        return None
    own, namespace = node.context.get_domain_id(), node.get_namespace()
    found = drivers()
    if any(domain == own and name.rpartition('/')[0] == namespace.rstrip('/')
           for domain, name in found):
        return None if waited < DISCOVERY_TIMEOUT else (
            f'waits for {what} in ROS domain {own}: a driver runs there, but ROS does not find '
            'it: is ROS_AUTOMATIC_DISCOVERY_RANGE or RMW_IMPLEMENTATION different there?')
    where = [_where(domain, name, own) for domain, name in found]
    return (f'waits for {what} in ROS domain {own}'
            + (f', namespace {namespace}' if namespace != '/' else '') + '; on this computer '
            + (', '.join(where) if where else 'no driver runs: start one with create_run'))


def _where(domain: int, name: str, own: int) -> str:
    namespace = name.rpartition('/')[0]
    reach = ([f'export ROS_DOMAIN_ID={domain}'] if domain != own else []) + (
        [f'--ros-args -r __ns:={namespace or "/"}'] if domain == own or namespace else [])
    return f'{name} runs in domain {domain} ({", ".join(reach)})'


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
    timer = node.create_timer(0.5, look)


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
