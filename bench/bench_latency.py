# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Latency of messages and commands: `python bench/bench_latency.py`, three minutes, a table.

Robot, driver, listener and commander are processes. All times are of the monotonic clock, which
they share. The time of a frame is when its last byte was written; of a message, when its callback
ran; of a command, just before it was published, and when all of Drive Direct had arrived. The
floor (programs/floor.py) is measured in the same way. Node and floor take turns.
"""

from collections import Counter
import json
from math import inf
from random import Random
from statistics import median
from time import monotonic, sleep
from typing import Any, NamedTuple

from create_oi_ros.sim.server.create_sim import say
from results import Figure, percentile, repeated, run
from scene import drives, Scene

REPETITIONS = 3
# Seconds to wait until all is quiet, and seconds in which odometry is measured.
SETTLE, LISTEN = 1.0, 6.0
COMMANDS, PRESSES = 200, 100

PERCENTILES = {'median': (50, 1.2, 0.9, 19.0), '99th percentile': (99, 1.5, 1.5, 27.0)}
"""Which, and at most: times the floor, ms of a command, ms of a bump. A bump waits for the
robot's next slot, up to 15 ms, and takes 10 ms on the line."""


class Latencies(NamedTuple):
    """Latencies of one run, seconds."""

    odom: list[float]
    commands: list[float]
    bumps: list[float]


def frame_latencies(sent: list[float], received: list[float]) -> list[float]:
    """
    Return the latency of each odometry message; there is one message for each frame.

    Frames carry no number, so messages are matched to frames by one constant shift of the index.
    The shift is the one that is right for most messages, if each came from the last frame sent
    before it. So a message that takes longer than a slot is not matched to the next frame.
    """
    latest = [sum(time < when for time in sent) - 1 for when in received]
    shift = Counter(place - index for index, place in enumerate(latest)).most_common(1)[0][0]
    return [when - sent[index + shift] for index, when in enumerate(received)
            if 0 <= index + shift < len(sent)]


def command_latencies(published: list[Any], received: list[Any]) -> list[float]:
    """Return the latency of each velocity command; infinity for one that never arrived."""
    arrived: dict[int, float] = {}
    for when, command in drives(received):
        arrived.setdefault(command.right, when)
    return [arrived.get(speed, inf) - when for when, speed in published]


def bump_latencies(presses: list[float], received: list[Any]) -> list[float]:
    """Return the latency of each press of the bumper, to the first message that shows it."""
    pressed = [
        when for (when, left), (_, before) in zip(received[1:], received) if left and not before]
    return [min((when - press for when in pressed if when >= press), default=inf)
            for press in presses]


def press(stage: Scene) -> None:
    """Press and release the simulated bumper at random times."""
    random = Random(1)
    for pressed in (1, 0) * PRESSES:
        sleep(random.uniform(0.025, 0.04))
        say(f'force bump_left={pressed}', stage.control)


def measured(*, floor: bool = False) -> Latencies:
    """Run the node once, or the floor."""
    with Scene() as stage:
        robot = stage.robot()
        listener = stage.program('listener', 'odom', 'bumper')
        driver = stage.driver(floor=floor)
        published = json.loads(stage.program('commander', str(COMMANDS)).line())
        sleep(SETTLE)
        begun = monotonic()
        sleep(LISTEN)
        ended = monotonic()
        if not floor:
            press(stage)
        driver.close()  # before its robot goes
        received = listener.result()
        log = robot.result()
    odoms = [when for when, _ in received['odom']]
    return Latencies(
        frame_latencies([t for t in log['sent'] if begun < t < ended],
                        [t for t in odoms if begun < t < ended]),
        command_latencies(published, log['received']),
        bump_latencies(log['presses'], received['bumper']))


def measure() -> list[Figure]:
    floor, node = zip(*((measured(floor=True), measured()) for _ in range(REPETITIONS)))
    made = []
    for which, (percent, most_odom, most_command, most_bump) in PERCENTILES.items():
        odom, least = ([1e3 * percentile(each.odom, percent) for each in runs]
                       for runs in (node, floor))
        commands, direct = ([1e3 * percentile(each.commands, percent) for each in runs]
                            for runs in (node, floor))
        made += [
            repeated(f'frame written to odom heard: {which}', [a / b for a, b in zip(odom, least)],
                     'x floor', most_odom,
                     f'{median(odom):.2f} ms, floor {median(least):.2f} ms'),
            repeated(f'cmd_vel published to Drive Direct on the wire: {which}', commands, 'ms',
                     most_command, f'floor {median(direct):.2f} ms'),
            repeated(f'bumper pressed to bumper heard: {which}',
                     [1e3 * percentile(each.bumps, percent) for each in node], 'ms', most_bump)]
    return made


if __name__ == '__main__':
    run('bench_latency', measure)
