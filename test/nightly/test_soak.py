# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Load and faults for half an hour; the node must not grow.

One node and one robot run as processes. The line fails at random: unplugged, cut, silent or
damaged; the robot's battery fails, too. Meanwhile `cmd_vel` arrives at 1 kHz, services are called
a hundred at a time, ten goals are sent at once and some canceled, one subscriber never reads, and
sometimes all cores are busy. The node's threads, descriptors and resident memory are measured
after the first minute and at the end.

The test fails if the sizes differ, the node has ended, a wrong value was published, a call or a
goal was not answered, or the newest command was late.
"""

from contextlib import closing
import os
from pathlib import Path
from random import Random
import signal
import subprocess
import sys
import time
from typing import NamedTuple

from create_oi_msgs.action import DriveDistance
from create_oi_msgs.srv import SetLeds
from geometry_msgs.msg import Twist, Vector3
import pytest
from rclpy.action.client import ActionClient
from std_srvs.srv import Trigger

from create_oi_ros.ros.services import QUEUE
from nightly.stage import Stage, staged
from support.nightly import SHARE
from support.ros import Program

SETTLE = 60.0
"""Seconds after which the node must have its final size."""
GROWTH = 2 << 20
"""Bytes of memory that the node may grow by."""
RATE = 1000
"""Velocity commands a second."""
CALLS = 100
"""Service calls at once."""
GOALS, WAY = 10, 0.02
"""Goals at once, and how far each leads, m."""
QUICKLY = 1.0
"""Seconds within which the robot must follow the newest command after a flood."""
FAULTS = (
    'unplug:0.03+1.5', 'cut:0.02+0.8', 'silence:0.02+1', 'deaf:0.02+0.5', 'brownout:0.01+0.1',
    'flip:0.02', 'drop:0.02', 'garbage:0.02')
ROBOT = ('--guess', 'boot_seconds=0', '--seed', '7')
ENDLESS_LOOP = 'while True: pass'
SUBSCRIBER = """
from nav_msgs.msg import Odometry
import rclpy
rclpy.init()
node = rclpy.create_node('frozen')
received = rclpy.task.Future()
node.create_subscription(
    Odometry, 'odom', lambda _: received.done() or received.set_result(True), 1000)
rclpy.spin_until_future_complete(node, received)
print('received', flush=True)
rclpy.spin(node)
"""
PAGE = os.sysconf('SC_PAGE_SIZE')


class Size(NamedTuple):
    """Size of a process."""

    threads: int
    descriptors: int
    resident: int
    """Resident memory, bytes."""


def size_of(number: int) -> Size:
    """Return the present size of a process."""
    process = Path(f'/proc/{number}')
    return Size(
        len(list((process / 'task').iterdir())), len(list((process / 'fd').iterdir())),
        int((process / 'statm').read_text('ascii').split()[1]) * PAGE)


class Soak:
    """One run of the soak."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._random = Random(7)
        self._called = self._commands = self._goals = self._results = 0
        self.troubles: list[str] = []
        self._leds = stage.ros.node.create_client(SetLeds, 'set_leds', qos_profile=QUEUE)
        self._stop = stage.ros.node.create_client(Trigger, 'stop', qos_profile=QUEUE)
        self._drive = ActionClient(
            stage.ros.node, DriveDistance, 'drive_distance', goal_service_qos_profile=QUEUE,
            result_service_qos_profile=QUEUE, cancel_service_qos_profile=QUEUE)

    def run(self, minutes: float) -> None:
        """Run for so many minutes."""
        stage, first = self._stage, None
        stage.start_robot(*ROBOT)
        stage.start_node(baud=0)
        stage.set_outputs()
        with closing(Program('-c', SUBSCRIBER, domain=stage.domain)) as subscriber:
            stage.until(lambda: 'received' in subscriber.output, 'a subscriber that hears odom')
            subscriber.send(signal.SIGSTOP)
            begun = time.monotonic()
            while (passed := time.monotonic() - begun) < 60 * minutes:
                if first is None and passed >= min(SETTLE, 20 * minutes):
                    first = self._size()
                self._round()
            stage.control.tell('fault off', 'cable mend')
            stage.until(self._recovered, 'the robot')
            last = self._size()
        print(f'from {first} to {last}; {self._commands} commands, {self._called} calls, '
              f'{self._goals} goals, {stage.watch.odoms} odom')
        self._compare(first, last)

    def _round(self) -> None:
        """Make faults, and one kind of load at random."""
        self._stage.control.tell(f'fault {" ".join(FAULTS)}')
        self._random.choice((
            self._flood, self._flood, self._call_services, self._pursue_goals, self._busy))()
        if self._random.random() < 0.2:
            self._stage.control.tell('fault off')
            self._newest_wins()
        if not self._stage.node.running():
            pytest.fail(f'the node has ended:\n{self._stage.node.output[-3000:]}')

    def _flood(self, seconds: float = 2.0) -> None:
        """Publish 1000 velocities a second."""
        begun, sent = time.monotonic(), 0

        def over() -> bool:
            nonlocal sent
            passed = time.monotonic() - begun
            while sent < passed * RATE:
                self._stage.publish(Twist(linear=Vector3(x=self._random.uniform(-0.3, 0.3))))
                sent += 1
            return passed >= seconds
        self._stage.until(over, 'the end of a flood')
        self._commands += sent

    def _call_services(self) -> None:
        """Call services, a hundred at once, and wait for all replies."""
        calls = [self._leds.call_async(SetLeds.Request(
            play=True, advance=True, power_color=77, power_intensity=88)) if number % 10 else
            self._stop.call_async(Trigger.Request()) for number in range(CALLS)]
        self._called += CALLS
        self._stage.until(lambda: all(call.done() for call in calls), 'a hundred replies')

    def _pursue_goals(self) -> None:
        """Send goals, each of which takes over from the one before; cancel the last or not."""
        sent = [self._drive.send_goal_async(DriveDistance.Goal(
            distance=self._random.choice((WAY, -WAY)))) for _ in range(GOALS)]
        self._goals += GOALS
        self._stage.until(lambda: all(each.done() for each in sent), 'goals that are accepted')
        handles = [each.result() for each in sent]
        results = [each.get_result_async() for each in handles if each.accepted]
        if self._random.random() < 0.5:
            handles[-1].cancel_goal_async()
        self._stage.until(lambda: all(each.done() for each in results), 'the results of goals')
        self._results += len(results)

    def _busy(self) -> None:
        """Publish velocities while other processes keep all cores busy."""
        loops = [subprocess.Popen([sys.executable, '-S', '-c', ENDLESS_LOOP])
                 for _ in range(os.cpu_count())]
        try:
            self._flood(3.0)
        finally:
            for loop in loops:
                loop.kill()
                loop.wait()

    def _newest_wins(self) -> None:
        """After a flood, measure how long the newest command takes to reach the robot."""
        stage = self._stage
        stage.until(self._recovered, 'the robot')
        self._flood(1.0)
        begun = time.monotonic()

        def arrived() -> bool:
            stage.publish(Twist(linear=Vector3(x=0.123)))
            return bool(stage.control.truth()['right'] == 123)
        stage.until(arrived, 'the newest command')
        took = time.monotonic() - begun
        if took > QUICKLY:
            self.troubles.append(f'the newest command took {took:.2f} s')

    def _recovered(self) -> bool:
        truth = self._stage.control.truth()
        if truth['mode'] != 'SAFE':
            # The battery failed while it drove: a stop, then a fresh command, bring Safe back.
            self._stage.publish(Twist())
            self._stage.publish(Twist(linear=Vector3(x=0.1)))
        return bool(truth['mode'] == 'SAFE')

    def _size(self) -> Size:
        """Measure when the link is up, so that the dead-man process runs, too."""
        self._stage.control.tell('fault off')
        self._stage.until(self._recovered, 'the robot')
        self._stage.wait(1.0)
        return size_of(self._stage.node.pid)

    def _compare(self, first: Size, last: Size) -> None:
        if last.threads != first.threads or last.descriptors != first.descriptors:
            self.troubles.append('the number of threads or descriptors has changed')
        grown = last.resident - first.resident
        if abs(grown) > GROWTH:
            self.troubles.append(f'resident memory has changed by {grown} bytes')
        if self._results != self._goals:
            self.troubles.append(f'{self._goals - self._results} goals had no result')
        self.troubles += self._stage.watch.wrong[:5]


@pytest.mark.nightly
@pytest.mark.timeout(7200)
def test_the_node_serves_and_does_not_grow(tmp_path):
    with staged(tmp_path) as stage:
        soak = Soak(stage)
        soak.run(30 * SHARE)
    assert not soak.troubles
