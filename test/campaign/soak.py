"""
A soak: everything at once for a long time, and nothing must grow.

    make soak ARGS= [MINUTES] [--json FILE]

One node and one robot, as processes. The line fails at random (unplugged, cut, silent, damaged;
the robot's battery fails), while `cmd_vel` comes at 1 kHz, services are called a hundred at a
time, a subscriber never reads, and now and then all cores are busy. Threads, descriptors and
bytes resident of the node are noted after the first minute and compared at the end; exit code 1
when they differ, when the node has ended, when a wrong value was published or a call not
answered, or when the newest command did not win. How it is, is said every minute.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
import json
import os
from pathlib import Path
from random import Random
import signal
import subprocess
import sys
from tempfile import TemporaryDirectory
import time
from typing import NamedTuple

from create_oi_msgs.srv import SetLeds
from geometry_msgs.msg import Twist, Vector3
from std_srvs.srv import Trigger

from campaign.stage import Stage, staged
from create_oi_ros.ros.services import AT_ONCE

SETTLE = 60.0
"""Seconds after which things must have found their size."""
GROWTH = 2 << 20
"""Bytes that the node may grow by."""
RATE = 1000
"""Velocity commands a second."""
CALLS = 100
"""Service calls at once."""
QUICKLY = 1.0
"""Seconds within which the newest command must be obeyed though all those came before it."""
FAULTS = (
    'unplug:0.03+1.5', 'cut:0.02+0.8', 'silence:0.02+1', 'deaf:0.02+0.5', 'brownout:0.01+0.1',
    'flip:0.02', 'drop:0.02', 'garbage:0.02')
ROBOT = ('--guess', 'boot_seconds=0', '--seed', '7')
BURN = 'while True: pass'
SUBSCRIBER = """
from nav_msgs.msg import Odometry
import rclpy
rclpy.init()
node = rclpy.create_node('frozen')
heard = rclpy.task.Future()
node.create_subscription(Odometry, 'odom', lambda _: heard.done() or heard.set_result(True), 1000)
rclpy.spin_until_future_complete(node, heard)
print('heard', flush=True)
rclpy.spin(node)
"""
PAGE = os.sysconf('SC_PAGE_SIZE')


class Size(NamedTuple):
    """What a process holds."""

    threads: int
    descriptors: int
    resident: int
    """Bytes."""


def size_of(number: int) -> Size:
    """Look at a process."""
    process = Path(f'/proc/{number}')
    return Size(
        len(list((process / 'task').iterdir())), len(list((process / 'fd').iterdir())),
        int((process / 'statm').read_text('ascii').split()[1]) * PAGE)


class Soak:
    """One scene that goes on and on."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._chance = Random(7)
        self._called = self._answered = self._commands = 0
        self.troubles: list[str] = []
        self._leds = stage.ros.node.create_client(SetLeds, 'set_leds', qos_profile=AT_ONCE)
        self._stop = stage.ros.node.create_client(Trigger, 'stop', qos_profile=AT_ONCE)

    def run(self, minutes: float) -> dict[str, object]:
        """Let it all happen; return what was seen."""
        stage = self._stage
        stage.start_robot(*ROBOT)
        stage.watch.follow(stage.control.truth)
        stage.start_node(baud=0)
        stage.furnish()
        with frozen_subscriber(stage.domain):
            try:
                return self._go_on(minutes)
            except TimeoutError as error:
                self.troubles.append(str(error))
                return {'trouble': str(error), 'truth': stage.control.truth(),
                        'node': stage.node.output[-3000:], 'commands': self._commands}

    def _go_on(self, minutes: float) -> dict[str, object]:
        stage, begun, first = self._stage, time.monotonic(), None
        settle = min(SETTLE, 20 * minutes)
        told = 0
        while (passed := time.monotonic() - begun) < 60 * minutes:
            if passed >= 60 * (told + 1):
                told = int(passed / 60)
                print(f'{told} min: {self._progress()}', flush=True)
            if first is None and passed >= settle:
                first = self._size()
                print(f'after {passed:.0f} s: {first}', flush=True)
            self._round()
        stage.control.tell('fault off', 'cable mend')
        stage.until(lambda: self._back(), 'the robot')
        last = self._size()
        print(f'after {60 * minutes:.0f} s: {last}', flush=True)
        self._compare(first or last, last)
        return {
            'minutes': minutes, 'first': (first or last)._asdict(), 'last': last._asdict(),
            'commands': self._commands, 'calls': self._called, 'answered': self._answered,
            'odometry messages': stage.watch.odoms, 'wrong values': stage.watch.wrong,
            'troubles': self.troubles}

    def _progress(self) -> str:
        """Say how it is, without waiting for anything."""
        threads, descriptors, resident = size_of(self._stage.node.pid)
        wrong = self._stage.watch.wrong or 'no wrong value'
        return (f'{threads} threads, {descriptors} descriptors, {resident / 1e6:.2f} MB, '
                f'{self._commands} commands, {self._answered} of {self._called} calls answered, '
                f'{wrong}, {len(self.troubles)} troubles')

    def _round(self) -> None:
        """Do one thing after the other, in an order that chance decides."""
        self._stage.control.tell(f'fault {" ".join(FAULTS)}')
        self._chance.choice((self._flood, self._flood, self._crowd, self._busy))()
        if self._chance.random() < 0.2:
            self._stage.control.tell('fault off')
            self._newest_wins()
        if not self._stage.node.running():
            raise SystemExit(f'the node has ended:\n{self._stage.node.output[-3000:]}')

    def _flood(self, seconds: float = 2.0) -> None:
        """Send velocities, 1000 a second."""
        begun, sent = time.monotonic(), 0

        def over() -> bool:
            nonlocal sent
            passed = time.monotonic() - begun
            while sent < passed * RATE:
                self._stage.say(Twist(linear=Vector3(x=self._chance.uniform(-0.3, 0.3))))
                sent += 1
            return passed >= seconds
        self._stage.until(over, 'the end of a flood')
        self._commands += sent

    def _crowd(self) -> None:
        """Call services, a hundred at once; all must be answered."""
        calls = [self._leds.call_async(SetLeds.Request(
            play=True, advance=True, power_color=77, power_intensity=88)) if number % 10 else
            self._stop.call_async(Trigger.Request()) for number in range(CALLS)]
        self._called += CALLS
        self._stage.until(lambda: all(call.done() for call in calls), 'a hundred replies')
        self._answered += sum(call.done() for call in calls)

    def _busy(self) -> None:
        """Let every core have something else to do."""
        with burning():
            self._flood(3.0)

    def _newest_wins(self) -> None:
        """After a flood, look how long the newest command takes to be the robot's."""
        stage = self._stage
        stage.until(self._back, 'the robot')
        self._flood(1.0)
        begun = time.monotonic()

        def arrived() -> bool:
            stage.say(Twist(linear=Vector3(x=0.123)))
            return bool(stage.control.truth()['right'] == 123)
        stage.until(arrived, 'the newest command')
        took = time.monotonic() - begun
        if took > QUICKLY:
            self.troubles.append(f'the newest command took {took:.2f} s')

    def _back(self) -> bool:
        truth = self._stage.control.truth()
        if truth['mode'] != 'SAFE':
            # A brownout while it drove: a pause, then a fresh command, bring Safe back.
            self._stage.say(Twist())
            self._stage.say(Twist(linear=Vector3(x=0.1)))
        return bool(truth['mode'] == 'SAFE')

    def _size(self) -> Size:
        """Measure when the line is whole, so that the dead-man is there, as at first."""
        self._stage.control.tell('fault off')
        self._stage.until(self._back, 'the robot')
        self._stage.rest(1.0)
        return size_of(self._stage.node.pid)

    def _compare(self, first: Size, last: Size) -> None:
        if last.threads != first.threads or last.descriptors != first.descriptors:
            self.troubles.append('threads or descriptors have changed in number')
        if abs(last.resident - first.resident) > GROWTH:
            self.troubles.append(f'{last.resident - first.resident} bytes more are resident')
        if self._answered != self._called:
            self.troubles.append(f'{self._called - self._answered} calls were not answered')
        self.troubles += self._stage.watch.wrong[:5]


@contextmanager
def burning() -> Iterator[None]:
    """Keep every core busy meanwhile."""
    fires = [subprocess.Popen([sys.executable, '-S', '-c', BURN]) for _ in range(os.cpu_count())]
    try:
        yield
    finally:
        for fire in fires:
            fire.kill()
            fire.wait()


@contextmanager
def frozen_subscriber(domain: int) -> Iterator[None]:
    """Let another process subscribe to everything fast, and stop it in its tracks."""
    subscriber = subprocess.Popen(
        [sys.executable, '-c', SUBSCRIBER], stdout=subprocess.PIPE,
        env={**os.environ, 'ROS_DOMAIN_ID': str(domain)})
    assert subscriber.stdout is not None
    assert subscriber.stdout.readline() == b'heard\n'
    subscriber.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        subscriber.kill()
        subscriber.wait()


def main() -> int:
    """Run it and say what was seen."""
    parser = argparse.ArgumentParser(prog='soak', description=__doc__)
    parser.add_argument('minutes', type=float, nargs='?', default=30.0)
    parser.add_argument('--json', type=Path, metavar='FILE')
    options = parser.parse_args()
    with TemporaryDirectory(prefix='soak-') as folder, staged(Path(folder)) as stage:
        soak = Soak(stage)
        seen = soak.run(options.minutes)
    for name, value in seen.items():
        print(f'{name}: {value}')
    if options.json:
        options.json.write_text(json.dumps(seen, indent=1), encoding='utf-8')
    return int(bool(soak.troubles))


if __name__ == '__main__':
    sys.exit(main())
