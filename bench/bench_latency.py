"""
How soon news arrive: `python bench/bench_latency.py`, two minutes, a table.

Robot, driver, listener and commander are processes of their own. Times are of the monotonic
clock, which they share: a frame's when its last byte was written, a message's when its callback
was called, a command's just before it was published and when Drive Direct had come whole. The
floor does the same with nothing in between (programs/floor.py), in turn with the node.
"""

from collections import Counter
import json
from math import inf
from pathlib import Path
from random import Random
import sys
from time import monotonic, sleep
from typing import Any, NamedTuple

from create_oi_ros import oi
from results import Figure, repeated, run
from scene import Scene, scene

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))
from support.simulator import Teacher

REPETITIONS = 3
SETTLE, LISTEN = 1.0, 6.0
"""Seconds after the last command, and while odometry is listened to."""
COMMANDS, PRESSES = 100, 100


class Seen(NamedTuple):
    """Seconds that each piece of news took, sorted."""

    odom: list[float]
    commands: list[float]
    bumps: list[float]


def frame_latencies(said: list[float], heard: list[float]) -> list[float]:
    """
    Return how long each message took; one belongs to each frame.

    Which to which: by the distance in number that fits most of them, were each to belong to the
    last frame before it. So a message that took longer than a slot is not taken for a quick one.
    """
    latest = [sum(time < when for time in said) - 1 for when in heard]
    shift = Counter(place - index for index, place in enumerate(latest)).most_common(1)[0][0]
    return sorted(when - said[index + shift] for index, when in enumerate(heard)
                  if 0 <= index + shift < len(said))


def command_latencies(spoken: list[Any], heard: list[Any]) -> list[float]:
    """Return how long each velocity took to the robot; one that came not at all took for ever."""
    arrived: dict[int, float] = {}
    reader = oi.CommandReader()
    for when, data in heard:
        reader.feed(bytes.fromhex(data))
        while (event := reader.next_event()) is not None:
            if isinstance(event, oi.DriveDirect):
                arrived.setdefault(event.right, when)
    return sorted(arrived.get(speed, inf) - when for when, speed in spoken)


def bump_latencies(presses: list[float], heard: list[Any]) -> list[float]:
    """Return how long each press took to its first message."""
    pressed = [when for (when, left), (_, before) in zip(heard[1:], heard) if left and not before]
    return sorted(min((when - press for when in pressed if when >= press), default=inf)
                  for press in presses)


def press(stage: Scene) -> None:
    """Press the bumper at moments that cannot be foretold."""
    teacher, chance = Teacher(stage.control), Random(1)
    for _ in range(PRESSES):
        sleep(chance.uniform(0.025, 0.04))
        teacher.tell('force bump_left=1')
        sleep(chance.uniform(0.025, 0.04))
        teacher.tell('force bump_left=0')
    teacher.close()


def watched(*, floor: bool) -> Seen:
    """Let the node, or the floor, do its work and be watched."""
    with scene() as stage:
        robot = stage.robot()
        listener = stage.listener('odom', 'bumper')
        stage.driver(floor=floor)
        commander = stage.program('commander', str(COMMANDS))
        commander.line()
        spoken = json.loads(commander.line())
        sleep(SETTLE)
        begun = monotonic()
        sleep(LISTEN)
        ended = monotonic()
        if not floor:
            press(stage)
        heard = listener.told()
        diary = robot.told()
    odoms = [when for when, _ in heard['odom']]
    return Seen(
        frame_latencies([t for t in diary['said'] if begun < t < ended],
                        [t for t in odoms if begun < t < ended]),
        command_latencies(spoken, diary['heard']),
        bump_latencies(diary['pressed'], heard['bumper']))


def at(latencies: list[float], share: float) -> float:
    """Return the time, ms, within which this share of the news came."""
    return 1e3 * latencies[min(len(latencies) - 1, int(share * len(latencies)))]


def compared(what: str, node: list[list[float]], floor: list[list[float]], share: float,
             target: float) -> Figure:
    """Compare the node with the floor of the same repetition."""
    ratios = [at(ours, share) / at(least, share) for ours, least in zip(node, floor)]
    ours, least = (sorted(at(each, share) for each in all_)[len(all_) // 2]
                   for all_ in (node, floor))
    return repeated(what, ratios, 'x floor', target, f'{ours:.2f} ms, floor {least:.2f} ms')


def measure() -> list[Figure]:
    """Measure everything."""
    floor, node = [], []
    for _ in range(REPETITIONS):
        floor.append(watched(floor=True))
        node.append(watched(floor=False))
    odom, least = [each.odom for each in node], [each.odom for each in floor]
    slot = 1e3 * oi.SLOT
    floor_99 = sorted(at(each, 0.99) for each in least)[REPETITIONS // 2]
    return [
        compared('frame written to odom heard: median', odom, least, 0.5, 1.2),
        compared('frame written to odom heard: 99th percentile', odom, least, 0.99, 1.5),
        compared('cmd_vel published to Drive Direct on the wire: median',
                 [each.commands for each in node], [each.commands for each in floor], 0.5, 1.3),
        repeated('bumper pressed to bumper heard: median',
                 [at(each.bumps, 0.5) for each in node], 'ms'),
        repeated('bumper pressed to bumper heard: 99th percentile',
                 [at(each.bumps, 0.99) for each in node], 'ms', slot + floor_99,
                 f"a slot of {slot:g} ms and the floor's {floor_99:.2f} ms"),
    ]


if __name__ == '__main__':
    run('bench_latency', measure)
