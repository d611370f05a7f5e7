# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Blink: Play and Advance in turns, the power LED from green to red; Ctrl-C ends it."""
import argparse
from itertools import count
import signal

from create_oi_msgs.srv import SetLeds
import rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from create_oi_ros.ros.waiting import wait_for_robot

argparse.ArgumentParser(description=__doc__).parse_args(remove_ros_args()[1:])
steps, ended = count(), []


def blink() -> None:
    step = next(steps)
    leds.call_async(SetLeds.Request(
        play=step % 2 == 0, advance=step % 2 == 1, power_color=step * 16 % 256,
        power_intensity=255))


try:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)  # Ctrl-C is a KeyboardInterrupt
    node = rclpy.create_node('leds')
    leds = node.create_client(SetLeds, 'set_leds')
    wait_for_robot(node, leds.service_is_ready)
    node.create_timer(0.25, blink)
    # Ctrl-C is only noted from here on: an exception could come amid a message.
    signal.signal(signal.SIGINT, lambda *_: ended.append('Ctrl-C'))
    while not ended:
        rclpy.spin_once(node, timeout_sec=0.1)
except KeyboardInterrupt:
    pass
