# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
What the command ros2 does, by rclpy: list, echo a topic, call a service, set a parameter.

    python examples/ros.py list
    python examples/ros.py echo /odom
    python examples/ros.py call /set_mode '{mode: 3}'
    python examples/ros.py set /create cmd_vel_timeout 1.0
"""
import argparse
from collections.abc import Callable
import importlib
import signal
import sys
import time
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
import rclpy
from rclpy.node import Node
from rclpy.parameter import get_parameter_value, Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args
import yaml

from create_oi_ros.ros.messages import filled
from create_oi_ros.ros.waiting import say_if_waiting, waits_for

WAIT, LONGEST_WAIT = 3.0, 10.0
"""Seconds in which others answer, and all are found once one is; in which one is, at most."""


def found(node: Node, services: bool) -> dict[str, str]:
    """Return the topics or services that are known now, with their types."""
    both = node.get_service_names_and_types() if services else node.get_topic_names_and_types()
    return {name: types[0] for name, types in both}


def awaited(look: Callable[[], Any]) -> Any:
    """Look until something is found; return what was seen last."""
    until = time.monotonic() + LONGEST_WAIT
    while not (seen := look()) and time.monotonic() < until:
        time.sleep(0.1)
    return seen


def imported(kind: str) -> Any:
    """Return the class of a type, such as create_oi_msgs/srv/SetMode."""
    package, folder, name = kind.split('/')
    return getattr(importlib.import_module(f'{package}.{folder}'), name)


def plain(value: Any) -> Any:
    """Return a message as a dictionary, and a list of any kind as a list."""
    if hasattr(value, 'get_fields_and_field_types'):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, (bool, int, float, str, bytes)):
        return value
    return [plain(each) for each in value]


def show(message: Any) -> None:
    """Print a message as YAML."""
    print(yaml.safe_dump(plain(message), sort_keys=False, allow_unicode=True), flush=True, end='')


def request_of(kind: str, text: str) -> Any:
    """Return a request with the fields in a text; ValueError: it is no YAML, or does not fit."""
    try:
        fields = yaml.safe_load(text or '{}')
    except yaml.YAMLError:
        fields = None
    if not isinstance(fields, dict):
        raise ValueError(f"{text!r} is no YAML of the form '{{field: value}}'")
    return filled(imported(kind).Request(check_fields=True), fields, kind)


def answer(node: Node, future: rclpy.task.Future) -> Any:
    """Return an answer; SystemExit says why none has come."""
    rclpy.spin_until_future_complete(node, future, timeout_sec=WAIT)
    if not future.done():
        sys.exit(waits_for(node, 'an answer', WAIT) or f'no answer within {WAIT:g} s')
    return future.result()


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('what', choices=['list', 'echo', 'call', 'set'])
    parser.add_argument('names', nargs='*', help='see the examples above')
    given = parser.parse_args(remove_ros_args()[1:])
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)  # Ctrl-C is a KeyboardInterrupt
    node = rclpy.create_node('ros')
    match given.what, given.names:
        case 'list', []:
            awaited(lambda: len(node.get_node_names()) > 1)  # one is this program itself
            time.sleep(WAIT)
            for services in (False, True):
                for name, kind in sorted(found(node, services).items()):
                    print(f'{name:40s} {kind}')
        case 'echo', [topic]:
            topic = node.resolve_topic_name(topic)
            offers = awaited(lambda: node.get_publishers_info_by_topic(topic))
            if not offers:
                parser.error(f'nobody publishes {topic}: see list')
            came: list[Any] = []

            def echo(message: Any) -> None:
                came[:] = [message]
                show(message)
                print('---', flush=True)
            offered = offers[0].qos_profile
            node.create_subscription(imported(offers[0].topic_type), topic, echo, QoSProfile(
                depth=10, reliability=offered.reliability, durability=offered.durability))
            say_if_waiting(node, topic, lambda: not came, lambda why: print(why, file=sys.stderr))
            # Ctrl-C is only noted from here on: an exception could come amid a message.
            ended: list[str] = []
            signal.signal(signal.SIGINT, lambda *_: ended.append('Ctrl-C'))
            while not ended:
                rclpy.spin_once(node, timeout_sec=0.1)
        case 'call', [service, *fields]:
            service = node.resolve_service_name(service)
            kind = awaited(lambda: found(node, True).get(service))
            if kind is None:
                parser.error(f'nobody offers {service}: see list')
            try:
                request = request_of(kind, ' '.join(fields))
            except ValueError as error:
                parser.error(str(error))
            client = node.create_client(imported(kind), service)
            client.wait_for_service(WAIT)
            show(answer(node, client.call_async(request)))
        case 'set', [name, parameter, value]:
            client = AsyncParameterClient(node, name)
            if not client.wait_for_services(WAIT):
                parser.error(f'no node {name} is found: see list')
            known = answer(node, client.list_parameters()).result.names
            if parameter not in known:
                parser.error(f'{name} has no parameter {parameter}; it has {", ".join(known)}')
            message = Parameter.from_parameter_msg(
                ParameterMessage(name=parameter, value=get_parameter_value(value)))
            for result in answer(node, client.set_parameters([message])).results:
                show(result)
        case _:
            parser.error(f'{given.what} takes other arguments: see --help')


try:
    main()
except (KeyboardInterrupt, BrokenPipeError):
    pass
