# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Latency of messages, commands and start-up: `python bench/bench_latency.py`, four minutes, tables.

Robot, driver, listener and commander are processes. All times are of the monotonic clock, which
they share. The time of a frame is when its last byte was written; of a message, when its callback
ran; of a command, just before it was published, and when all of Drive Direct had arrived. The
floor (programs/floor.py) is measured in the same way. Node and floor take turns. Start-up is
measured from the start of the process to its first `odom` in a listener that runs already.
"""

from collections import Counter
import json
from math import inf
from random import Random
from time import monotonic, sleep
from typing import Any, NamedTuple

from create_oi_ros import oi
from create_oi_ros.driver import Settings
from create_oi_ros.driver.stream import StreamPlan
from results import Figure, repeated, run
from scene import drives, Scene, scene

REPETITIONS, STARTS = 3, 5
# Seconds to wait until all is quiet, and seconds in which odometry is measured.
SETTLE, LISTEN = 1.0, 6.0
COMMANDS, PRESSES = 100, 100


class Latencies(NamedTuple):
    """Latencies of one run, seconds, each list sorted."""

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
    return sorted(when - sent[index + shift] for index, when in enumerate(received)
                  if 0 <= index + shift < len(sent))


def command_latencies(published: list[Any], received: list[Any]) -> list[float]:
    """Return the latency of each velocity command; infinity for one that never arrived."""
    arrived: dict[int, float] = {}
    for when, command in drives(received):
        arrived.setdefault(command.right, when)
    return sorted(arrived.get(speed, inf) - when for when, speed in published)


def bump_latencies(presses: list[float], received: list[Any]) -> list[float]:
    """Return the latency of each press of the bumper, to the first message that shows it."""
    pressed = [
        when for (when, left), (_, before) in zip(received[1:], received) if left and not before]
    return sorted(min((when - press for when in pressed if when >= press), default=inf)
                  for press in presses)


def press(stage: Scene) -> None:
    """Press and release the simulated bumper at random times."""
    random = Random(1)
    with stage.control_socket() as send:
        for _ in range(PRESSES):
            sleep(random.uniform(0.025, 0.04))
            send('force bump_left=1')
            sleep(random.uniform(0.025, 0.04))
            send('force bump_left=0')


def measured(*, floor: bool = False) -> Latencies:
    """Run the node once, or the floor."""
    with scene() as stage:
        robot = stage.robot()
        listener = stage.listener('odom', 'bumper')
        stage.driver(floor=floor)
        commander = stage.program('commander', str(COMMANDS))
        commander.line()
        published = json.loads(commander.line())
        sleep(SETTLE)
        begun = monotonic()
        sleep(LISTEN)
        ended = monotonic()
        if not floor:
            press(stage)
        received = listener.result()
        log = robot.result()
    odoms = [when for when, _ in received['odom']]
    return Latencies(
        frame_latencies([t for t in log['sent'] if begun < t < ended],
                        [t for t in odoms if begun < t < ended]),
        command_latencies(published, log['received']),
        bump_latencies(log['presses'], received['bumper']))


def at(latencies: list[float], share: float) -> float:
    """Return a percentile of sorted latencies, ms; 0.5 is the median."""
    return 1e3 * latencies[min(len(latencies) - 1, int(share * len(latencies)))]


def compared(what: str, node: list[list[float]], floor: list[list[float]], share: float,
             target: float | None = None) -> Figure:
    """Return the ratio of the node to the floor of the same repetition, at a percentile."""
    ratios = [at(ours, share) / at(least, share) for ours, least in zip(node, floor)]
    ours, least = (sorted(at(each, share) for each in all_)[len(all_) // 2]
                   for all_ in (node, floor))
    return repeated(what, ratios, 'x floor', target, f'{ours:.2f} ms, floor {least:.2f} ms')


def measure() -> list[Figure]:
    floor, node = [], []
    for _ in range(REPETITIONS):
        floor.append(measured(floor=True))
        node.append(measured())
    odom, least = [each.odom for each in node], [each.odom for each in floor]
    slot = 1e3 * oi.SLOT
    wire = 1e3 * StreamPlan(Settings.baud).short.budget(Settings.baud).seconds
    floor_99 = sorted(at(each, 0.99) for each in least)[REPETITIONS // 2]
    return [
        compared('frame written to odom heard: median', odom, least, 0.5, 1.2),
        compared('frame written to odom heard: 99th percentile', odom, least, 0.99, 1.5),
        repeated('cmd_vel published to Drive Direct on the wire: median',
                 [at(each.commands, 0.5) for each in node], 'ms', 2.0,
                 f'floor {sorted(at(each.commands, 0.5) for each in floor)[1]:.2f} ms'),
        repeated('bumper pressed to bumper heard: median',
                 [at(each.bumps, 0.5) for each in node], 'ms'),
        repeated('bumper pressed to bumper heard: 99th percentile',
                 [at(each.bumps, 0.99) for each in node], 'ms', slot + wire + floor_99,
                 f'a slot of {slot:g} ms, {wire:.1f} ms on the line, '
                 f"the floor's {floor_99:.2f} ms"),
    ]


def first_odom(*, floor: bool = False) -> float:
    """Return the seconds from the start of a process to its first `odom`."""
    with scene() as stage:
        stage.robot()
        listener = stage.listener('odom')
        sleep(SETTLE)
        begun = monotonic()
        stage.driver(floor=floor)
        listener.line()
        return float(listener.result()['odom'][0][0]) - begun


def measure_start() -> list[Figure]:
    floor, node = zip(*((first_odom(floor=True), first_odom()) for _ in range(STARTS)))
    return [repeated('process start to first odom', node, 's', 1.5),
            repeated('floor: process start to first odom', floor, 's')]


if __name__ == '__main__':
    run('bench_latency', measure)
    run('bench_start', measure_start)
