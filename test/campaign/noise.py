"""A line that damages frames, in memory: what is published must be what the robot sent."""

from dataclasses import dataclass, field
from random import Random

from create_oi_ros import oi
from create_oi_ros.sim.server.faults import Fault, Faults
from support.loop import Loop

KINDS = ('flip', 'drop', 'garbage')
LEAST_KEPT = 0.8
"""Part of the undamaged frames that must be published."""


@dataclass
class Noise:
    """What a damaged line made of what was sent."""

    undamaged: int = 0
    """Frames that came through whole."""
    published: int = 0
    """Frames that the driver took for true."""
    wrong: list[bytes] = field(default_factory=list)
    """Those among them that the robot never sent."""
    lost: int = 0
    """Times at which the robot was taken to be away."""

    @property
    def kept(self) -> float:
        """Part of the undamaged frames that were published."""
        return (self.published - len(self.wrong)) / self.undamaged


class Ears:
    """Stands between a robot and its driver; damages what is said, and keeps count."""

    def __init__(self, loop: Loop, rate: float, seed: int) -> None:
        self.noise = Noise()
        self._loop = loop
        self._faults = Faults([Fault.parse(f'{kind}:{rate}') for kind in KINDS], seed)
        self._say, loop.robot.data_to_send = loop.robot.data_to_send, self._damaged
        self._take, loop.driver._take_frame = loop.driver._take_frame, self._taken
        self._sent: set[bytes] = set()

    def _damaged(self) -> bytes:
        said = self._say()
        reader = oi.StreamReader(self._loop.driver.plan.lists)
        reader.feed(said)
        frames = [event.data for event in iter(reader.next_event, None)
                  if isinstance(event, oi.Frame)]
        self._sent.update(frames)
        heard = self._faults.from_robot(said, self._loop.now) if said else b''
        self.noise.undamaged += sum(frame in heard for frame in frames)
        return heard

    def _taken(self, frame: oi.Frame, now: float) -> None:
        driver = self._loop.driver
        before = driver.counts.frames
        self._take(frame, now)
        if driver.counts.frames > before:
            self.noise.published += 1
            if frame.data not in self._sent:
                self.noise.wrong.append(frame.data)


def noise(seed: int, seconds: int, *, rate: float = 0.05,
          checksum: oi.Checksum = oi.Checksum.HARDWARE) -> Noise:
    """Drive about with sensors that change all the time, on a bad line."""
    loop, chance = Loop(checksum=checksum), Random(seed)
    loop.run(0.5)
    assert loop.driver.state.answered
    ears = Ears(loop, rate, seed)
    for _ in range(seconds):
        loop.body.force(
            analog=chance.randrange(1024), cliff_left_signal=chance.randrange(4096),
            voltage=chance.randrange(13000, 17000), infrared=chance.randrange(256))
        loop.drive(chance.uniform(-0.4, 0.4), chance.uniform(-2.0, 2.0), 1.0)
    ears.noise.lost = loop.driver.counts.silences
    return ears.noise
