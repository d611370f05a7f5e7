# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
How often `create_check` is right: blind trials on robots drawn at random (`robots`).

    python bench/bench_check.py [ROBOTS [FIRST_SEED]]

Driver and simulated robot are connected in memory by a line with delays; each robot does the whole
program. Rounding, sign and response must be right on 95 of 100, time constants within 15 %, gains
within 1 %.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
import sys
import time

from create_oi_ros.apps.check.conclusion import conclude, Conclusion, time_constant
from create_oi_ros.apps.check.dead_band_search import DeadBandSearch
from create_oi_ros.apps.check.moves import Move, STEPS
from create_oi_ros.apps.check.notebook import Notebook
from create_oi_ros.apps.check.runner import Runner
from create_oi_ros.apps.check.trial_wheels import Family, Kind
from create_oi_ros.driver import Driver
from create_oi_ros.odometry import SignSource
from create_oi_ros.oi.tools import markdown
from create_oi_ros.robot import FIRMWARE_SEPARATION
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.body.config import EncoderSign
from create_oi_ros.sim.body.wheels import REFERENCE_SPEED, Response
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import World
from odometry_loop import Line, TURNS
from results import Figure, keep, machine, rows
from robots import CLASSES, Robot

SIGNS = {EncoderSign.DRIVE: SignSource.DRIVE, EncoderSign.UNTIL_REST: SignSource.LAST_REQUEST,
         EncoderSign.COMMAND: SignSource.REQUEST, EncoderSign.TRUE: SignSource.MOTION}
LATENCY = 0.01
"""Seconds of delay on the line each way, at most."""
QUICK = 0.3
"""m/s at which time constants are compared besides the speed of which they are known."""
PATIENCE = 6000
"""Turns of the loop that a move may take."""


class Floor:
    """A robot on the floor, and the check of it."""

    def __init__(self, robot: Robot, seed: int) -> None:
        self.body = Body(World(), rounding=robot.rounding, config=robot.config, seed=seed)
        self.robot = Create(self.body, guesses=Guesses(
            boot_seconds=0.0, banner=False, frame_period=robot.period))
        self.notebook = Notebook()
        self.driver = Driver(odometry=self.notebook)
        self.runner = Runner(self.driver, self.notebook)
        random = Random(seed)
        self._up, self._down = Line(random, LATENCY), Line(random, LATENCY)
        self._step = robot.period / TURNS
        self.now = 0.0
        self.driver.connected(self.now)
        for _ in range(200):
            self.go()

    def go(self) -> None:
        """Let a step of time pass."""
        self.now += self._step
        self.robot.poll(self.now)
        self._down.put(self.robot.data_to_send(), self.now)
        self.driver.receive(self._down.take(self.now), self.now)
        self.driver.poll(self.now)
        self.runner.poll(self.now)
        self._up.put(self.driver.data_to_send(), self.now)
        self.robot.receive(self._up.take(self.now), self.now)
        while self.driver.next_event() is not None:
            pass

    def make(self, move: Move) -> None:
        """Make a move."""
        self.runner.begin(move)
        for _ in range(PATIENCE):
            self.go()
            if not self.runner.busy:
                break
        assert self.runner.disturbance is None, self.runner.disturbance
        assert not self.runner.busy

    def check(self) -> Conclusion:
        """Do the whole program."""
        for step in STEPS:
            for move in step.moves:
                self.make(move)
        pages, search = list(self.runner.pages), DeadBandSearch()
        while (move := search.next_move()) is not None:
            self.make(move)
            search.learn(self.runner.pages[-1])
        return conclude(pages, search.band, self.driver.health(self.now).frame_period)


@dataclass(frozen=True)
class Score:
    """What was right, and how far numbers were off."""

    rounding: bool
    sign: bool
    response: bool
    dead_band: bool
    tau: float
    """Relative error of the time constant at 66 mm/s, or of a ramp's acceleration."""
    gain: float
    """Worst relative error of a wheel's speed at 0.3 m/s."""
    dead_time: float
    """Seconds."""
    separation: float
    period: float
    """Relative."""


def score(robot: Robot, found: Conclusion) -> Score:
    """Compare what was found with the truth."""
    config, known, kind = robot.config, found.knowledge, found.wheels.kind
    rounding, sign = known.likeliest
    if config.response is Response.RAMP:
        tau = abs(kind[Kind.BOUND] * config.wheel_acceleration - 1)
    else:
        tau = abs(time_constant(kind, REFERENCE_SPEED)
                  / config.time_constant.at(REFERENCE_SPEED) - 1)
    gains = ((Kind.RIGHT_GAIN, Kind.RIGHT_OFFSET, config.right_speed_gain),
             (Kind.LEFT_GAIN, Kind.LEFT_OFFSET, config.left_speed_gain))
    stands, moves = known.dead_band
    return Score(
        rounding.value == robot.rounding.value, sign is SIGNS[config.encoder_sign],
        response_of(found) is config.response, stands <= config.dead_band <= moves, float(tau),
        max(abs((kind[gain] + kind[offset] / QUICK) / true - 1) for gain, offset, true in gains),
        abs(float(kind[Kind.DEAD_TIME]) - config.dead_time),
        abs(known.separation_factor.value / (config.encoder_separation / FIRMWARE_SEPARATION) - 1),
        abs(known.frame_period.value / robot.period - 1))


def response_of(found: Conclusion) -> Response:
    """Return the response that was found."""
    if found.wheels.start.family is Family.SPRING:
        return Response.SECOND_ORDER
    return Response.RAMP if found.is_ramp else Response.FIRST_ORDER


def trials(count: int, first: int) -> Iterator[Score]:
    """Check robots; print a line each."""
    for seed in range(first, first + count):
        robot = CLASSES['centre' if seed % 5 == 0 else 'all ranges'](Random(seed))
        began = time.monotonic()
        result = score(robot, Floor(robot, seed).check())
        config = robot.config
        print(f'{seed}: {config.response.value}, {config.encoder_sign.value}, '
              f'{robot.rounding.value}: response {"right" if result.response else "WRONG"}, sign '
              f'{"right" if result.sign else "WRONG"}, rounding '
              f'{"right" if result.rounding else "WRONG"}, dead band '
              f'{"right" if result.dead_band else "WRONG"}; time constant {result.tau:.1%}, gain '
              f'{result.gain:.2%}, dead time {1000 * result.dead_time:.1f} ms off '
              f'({time.monotonic() - began:.0f} s)', flush=True)
        yield result


def figures(results: list[Score]) -> list[Figure]:
    """Return how often each guess was right, and how far numbers were off."""
    count, made = len(results), []
    for name in ('rounding', 'sign', 'response', 'dead_band'):
        right = 100 * sum(getattr(each, name) for each in results) / count
        made.append(Figure(f'{name.replace("_", " ")} right, of {count} robots', right, '%', 95.0,
                           at_least=True))
    for name, unit, factor, most in (
            ('tau', '%', 100, 15.0), ('gain', '%', 100, 1.0), ('dead_time', 'ms', 1000, None),
            ('separation', '%', 100, None), ('period', 'ppm', 1e6, None)):
        errors = [factor * getattr(each, name) for each in results]
        label = {'tau': 'time constant'}.get(name, name.replace('_', ' '))
        made.append(Figure(f'{label}: error', sum(errors) / count, unit, most,
                           worst=max(errors)))
        if most is not None:
            within = 100 * sum(error <= most for error in errors) / count
            made.append(Figure(f'{label} within {most:g} %, of {count} robots', within, '%', 95.0,
                               at_least=True))
    return made


def main() -> None:
    """Print the table, and save it."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    where = machine()
    found = figures(list(trials(count, int(sys.argv[2]) if len(sys.argv) > 2 else 1000)))
    heading, *body = rows(found)
    print(markdown.table(heading, body))
    keep('bench_check', found, where)


if __name__ == '__main__':
    main()
