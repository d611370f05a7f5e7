# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A line that falls silent, loses or damages frames, ends or is slow."""

from itertools import pairwise
from math import hypot, radians
from random import Random

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Activity, Severity
from create_oi_ros.driver.connection import SILENCE
from create_oi_ros.sim.body.config import DEFAULT_BODY
from create_oi_ros.sim.server.faults import Fault, Faults
from support.loop import Loop, texts, turn_difference
from support.nightly import NIGHTLY, SHARE


def test_silence_is_said_once_and_the_robot_is_called_until_it_answers(loop):
    loop.drive(0.2, 0.0, 0.3)
    loop.cut = True
    loop.run(5 * SILENCE)
    assert loop.driver.state.activity is Activity.CALLING
    assert loop.driver.status.actual is None
    said = [text.partition(':')[0] for text in texts(loop.notices, Severity.ERROR)]
    assert said == [f'no frame for {SILENCE} s', 'no answer at 57600 baud']
    assert loop.body.truth().speed > 0, 'the last Drive holds for ever'
    loop.cut = False
    loop.run(1.0)
    assert loop.driver.state.answered
    assert loop.robot.mode is oi.Mode.SAFE
    loop.run(0.5)
    assert loop.body.truth().speed == 0


def test_a_silence_that_has_ended_is_not_shown_after_a_standstill_of_the_driver(loop):
    loop.cut = True
    loop.run(2 * SILENCE)
    assert loop.driver.health(loop.now).line_problem.startswith('no frame for')
    loop.cut = False
    loop.run(1.0)
    loop.now += 5.0
    loop.driver.poll(loop.now)
    assert loop.driver.state.activity is Activity.CALLING
    assert loop.driver.health(loop.now).line_problem is None


def test_odometry_goes_on_after_silence_without_a_jump(loop):
    loop.drive(0.2, 0.0, 1.0)
    loop.run(0.5)
    seen = len(loop.moved)
    loop.cut = True
    loop.run(2.0)
    loop.cut = False
    loop.run(1.0)
    went = [moved.estimate.x for moved in loop.moved[seen - 1:]]
    assert all(abs(b - a) < 0.008 for a, b in pairwise(went))
    assert loop.estimate.x == pytest.approx(loop.body.truth().pose.x, abs=0.03)


@pytest.mark.parametrize('gap', [0.1, 0.2, 0.3, 0.4, 0.45])
def test_odometry_says_what_was_driven_while_frames_were_lost(loop, gap):
    loop.drive(0.2, 0.0, 3.0)
    off = loop.estimate.x - loop.body.truth().pose.x
    seen = len(loop.moved)
    loop.cut = True
    loop.drive(0.2, 0.0, gap)
    loop.cut = False
    loop.drive(0.2, 0.0, 1.0)
    assert loop.estimate.x - loop.body.truth().pose.x == pytest.approx(off, abs=0.002)
    for before, after in pairwise(loop.moved[seen - 1:]):
        seconds = after.stamp - before.stamp
        assert after.estimate.x - before.estimate.x == pytest.approx(0.2 * seconds, abs=0.003)


@pytest.fixture(scope='module')
def taught():
    """Return a driver that knows its robot: the first seconds have errors of their own."""
    made = Loop()
    made.run(0.3)
    for lesson in ((0.3, 0.0), (-0.2, 0.0), (0.0, 1.5), (0.0, -1.0), (0.2, 0.5), (0.0, 0.0)) * 3:
        made.drive(*lesson, 2.0)
    return made


@pytest.mark.parametrize(('speeds', 'gap', 'still'), [
    ((0.3, 0.0), 0.1, 0.0), ((0.3, 0.0), 0.45, 0.05), ((0.0, 2.0), 0.2, 0.0),
    ((0.0, 2.0), 0.45, 0.2), ((0.2, 1.0), 0.3, 0.05), ((0.2, 1.0), 0.45, 0.0)])
def test_what_was_driven_while_frames_were_lost_is_not_what_is_driven_now(
        taught, gap, speeds, still):
    loop = taught

    def miss():
        estimate, truth = loop.estimate, loop.body.truth()
        return estimate.x - truth.pose.x, estimate.y - truth.pose.y, estimate.yaw - truth.turned

    def off():
        now = miss()
        return hypot(now[0] - before[0], now[1] - before[1]), abs(now[2] - before[2])
    loop.drive(*speeds, 3.0)
    before = miss()
    loop.cut = True
    loop.drive(*speeds, gap)
    loop.cut = False
    loop.drive(*speeds, still)
    most = [each + 0.2 for each in off()]
    for _ in range(6):
        loop.drive(-speeds[0], -speeds[1], 0.1)
        assert all(now < limit for now, limit in zip(off(), most, strict=True))
    loop.drive(0.0, 0.0, 1.0)
    assert off() == pytest.approx((0.0, 0.0), abs=0.15)


def test_the_delay_of_the_line_does_not_matter():
    loop = Loop(delay=0.03)
    loop.run(0.5)
    loop.drive(0.2, 0.5, 3.0)
    loop.run(1.0)
    assert loop.estimate.x == pytest.approx(loop.body.truth().pose.x, abs=0.01)


# Frames that come late, as on a busy computer, say what was: the driver must not act on it.


class PausingLoop(Loop):
    """A computer that does not run at all now and then; bytes wait for it."""

    paused_until = 0.0

    def _arrived(self, line):
        return None if self.now < self.paused_until else super()._arrived(line)


@pytest.mark.parametrize('delay', [0.05, 0.2, 0.3, 0.45])
def test_a_robot_that_answers_late_is_not_said_to_have_left_its_mode(delay):
    loop = Loop()
    loop.run(3.0)
    loop.cut, loop.delay = True, delay
    loop.run(0.6)  # the driver calls again, and the robot's last frames in Safe come first
    loop.cut = False
    loop.run(4.0)
    assert loop.driver.status.actual is oi.Mode.SAFE
    assert not [notice.text for notice in loop.notices if 'robot left' in notice.text]


@pytest.mark.parametrize('seed', range(3))
def test_pauses_of_the_computer_do_not_spoil_the_odometry(seed):
    chance, loop = Random(seed), PausingLoop(config=DEFAULT_BODY, delay=0.005)
    loop.run(3.0)
    for _ in range(20):
        loop.drive(0.0, 1.0, chance.uniform(0.2, 1.8))
        loop.paused_until = loop.now + chance.uniform(0.06, 0.1)
    loop.run(3.0)
    truth = loop.body.truth().pose.yaw
    assert turn_difference(loop.estimate.yaw, truth) < radians(4)


# A line that damages frames: every published frame must be one that was sent.


KINDS = ('flip', 'drop', 'garbage')
LEAST_KEPT = 0.8
"""Share of the undamaged frames that must be published."""


class NoisyLine:
    """Damages what the robot sends, and counts which frames the driver accepts."""

    def __init__(self, loop: Loop, rate: float, seed: int) -> None:
        self.undamaged = 0
        """Frames that arrived undamaged."""
        self.published = 0
        """Frames that the driver accepted."""
        self.wrong: list[bytes] = []
        """Accepted frames that the robot never sent."""
        self._loop = loop
        self._faults = Faults([Fault.parse(f'{kind}:{rate}') for kind in KINDS], seed)
        self._send, loop.robot.data_to_send = loop.robot.data_to_send, self._damaged
        self._take, loop.driver._take_frame = loop.driver._take_frame, self._count
        self._sent: set[bytes] = set()

    def _damaged(self) -> bytes:
        sent = self._send()
        reader = oi.StreamReader(self._loop.driver.plan.lists)
        reader.feed(sent)
        frames = [event.data for event in iter(reader.next_event, None)
                  if isinstance(event, oi.Frame)]
        self._sent.update(frames)
        received = self._faults.from_robot(sent, self._loop.now) if sent else b''
        self.undamaged += sum(frame in received for frame in frames)
        return received

    def _count(self, frame: oi.Frame, now: float) -> None:
        driver = self._loop.driver
        before = driver.counts.frames
        self._take(frame, now)
        if driver.counts.frames > before:
            self.published += 1
            if frame.data not in self._sent:
                self.wrong.append(frame.data)


@pytest.mark.parametrize('checksum', oi.Checksum)
@pytest.mark.parametrize(('seed', 'seconds'), [
    (0, 5), pytest.param(2, 600 * SHARE, marks=NIGHTLY)])
def test_on_a_noisy_line_only_frames_that_were_sent_are_published(seed, seconds, checksum):
    """Drive at random, with sensors that change every second."""
    loop, random = Loop(checksum=checksum), Random(seed)
    loop.run(0.5)
    assert loop.driver.state.answered
    noise = NoisyLine(loop, 0.05, seed)
    for _ in range(round(seconds)):
        loop.body.force(
            analog=random.randrange(1024), cliff_left_signal=random.randrange(4096),
            voltage=random.randrange(13000, 17000), infrared=random.randrange(256))
        loop.drive(random.uniform(-0.4, 0.4), random.uniform(-2.0, 2.0), 1.0)
    assert not noise.wrong
    assert noise.published > 50 * seconds
    assert noise.published >= LEAST_KEPT * noise.undamaged
    assert not loop.driver.counts.silences
