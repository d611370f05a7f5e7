# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A line that damages frames, in memory: every published frame must be one that was sent."""

from random import Random

import pytest

from create_oi_ros import oi
from create_oi_ros.sim.server.faults import Fault, Faults
from support.loop import Loop
from support.nightly import NIGHTLY, SHARE

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
