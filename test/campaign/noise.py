# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A line that damages frames, in memory: every published frame must be one that was sent."""

from dataclasses import dataclass, field
from random import Random

from create_oi_ros import oi
from create_oi_ros.sim.server.faults import Fault, Faults
from support.loop import Loop

KINDS = ('flip', 'drop', 'garbage')
LEAST_KEPT = 0.8
"""Share of the undamaged frames that must be published."""


@dataclass
class Noise:
    """What happened to the frames of one run."""

    undamaged: int = 0
    """Frames that arrived undamaged."""
    published: int = 0
    """Frames that the driver accepted."""
    wrong: list[bytes] = field(default_factory=list)
    """Accepted frames that the robot never sent."""
    lost: int = 0
    """Times that the driver took the link for lost."""

    @property
    def kept(self) -> float:
        """Share of the undamaged frames that were accepted."""
        return (self.published - len(self.wrong)) / self.undamaged


class NoisyLine:
    """Damages what the robot sends, and counts which frames the driver accepts."""

    def __init__(self, loop: Loop, rate: float, seed: int) -> None:
        self.noise = Noise()
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
        self.noise.undamaged += sum(frame in received for frame in frames)
        return received

    def _count(self, frame: oi.Frame, now: float) -> None:
        driver = self._loop.driver
        before = driver.counts.frames
        self._take(frame, now)
        if driver.counts.frames > before:
            self.noise.published += 1
            if frame.data not in self._sent:
                self.noise.wrong.append(frame.data)


def noise(seed: int, seconds: int, *, rate: float = 0.05,
          checksum: oi.Checksum = oi.Checksum.HARDWARE) -> Noise:
    """Drive at random on a noisy line, with sensors that change every second."""
    loop, random = Loop(checksum=checksum), Random(seed)
    loop.run(0.5)
    assert loop.driver.state.answered
    line = NoisyLine(loop, rate, seed)
    for _ in range(seconds):
        loop.body.force(
            analog=random.randrange(1024), cliff_left_signal=random.randrange(4096),
            voltage=random.randrange(13000, 17000), infrared=random.randrange(256))
        loop.drive(random.uniform(-0.4, 0.4), random.uniform(-2.0, 2.0), 1.0)
    line.noise.lost = loop.driver.counts.silences
    return line.noise
