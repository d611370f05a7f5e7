"""A robot, a node and a listener as processes of their own; what is published is watched."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import signal
import time
from typing import Any

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import DefineSong, SetDigitalOutputs, SetLeds
import domain_coordinator
from geometry_msgs.msg import Twist, Vector3

from campaign.watch import Watch
from create_oi_ros.ros.programs import PROGRAMS
from support.ros import Listener, Program
from support.simulator import ControlClient

PATIENCE = 15.0
"""Seconds after which what should happen is taken not to."""
LOOK_EVERY = 0.01
"""Seconds between two looks at the truth."""
HELD = (
    'bump_left=0 bump_right=0 drop_left=0 drop_right=0 drop_caster=0 wall=0 wall_signal=1234 '
    'cliff_left=0 cliff_front_left=0 cliff_front_right=0 cliff_right=0 cliff_left_signal=1001 '
    'cliff_front_left_signal=2002 cliff_front_right_signal=3003 cliff_right_signal=404 '
    'virtual_wall=0 infrared=130 play=0 advance=0 charging_state=0 voltage=15123 current=-321 '
    'temperature=27 charge=2001 capacity=2702 home_base=0 internal_charger=0 digital_input_0=1 '
    'digital_input_1=0 digital_input_2=1 digital_input_3=0 analog=700')
"""Every sensor at one value for ever: whatever else is published is wrong."""
SONG = 3
RESTORED = {'mode': 'SAFE', 'leds': 10, 'power_color': 77, 'power_intensity': 88, 'outputs': 5}
"""What the truth must say after a fault as it did before."""


class Stage:
    """One robot, one node, one who drives."""

    def __init__(self, folder: Path, domain: int) -> None:
        self.folder, self.domain = folder, domain
        self.port = folder / 'create'
        self.ros = Listener(domain)
        self.watch = Watch(self.ros)
        self.robot: Program | None = None
        self.node: Program | None = None
        self._control: ControlClient | None = None
        self._velocity = self.ros.node.create_publisher(Twist, 'cmd_vel', 1)
        self._robots = 0

    @property
    def control(self) -> ControlClient:
        """Who sets the robot's world."""
        assert self._control is not None
        return self._control

    def start_robot(self, *arguments: str) -> None:
        """Switch a new robot on, its sensors held; the port is there when they are."""
        self._robots += 1
        link, control = self.folder / f'tty{self._robots}', self.folder / f'control{self._robots}'
        self.robot = Program('-c', PROGRAMS['create_sim'], '--link', str(link), '--control',
                             str(control), *(arguments or QUICK), domain=self.domain)
        self.until(lambda: control.exists() and 'help' in self.robot.output, 'a robot')
        self._control = ControlClient(control)
        self.control.tell(f'force {HELD}')
        beside = self.folder / 'beside'
        beside.symlink_to(link)
        beside.replace(self.port)

    def end_robot(self) -> None:
        """Let the robot's process die."""
        # As a cable does that is pulled out: its name goes with it, and may come to another.
        (self.folder / f'tty{self._robots}').unlink(missing_ok=True)
        _kill(self.robot)
        if self._control is not None:
            self._control.close()

    def start_node(self, *, code: str = PROGRAMS['create_node'], **parameters: object) -> None:
        """Start the driver and wait until it has the robot; set LEDs, outputs and a song."""
        self.watch.restart()
        arguments = [f'port:={self.port}', *(f'{n}:={value}' for n, value in parameters.items())]
        self.node = Program(
            '-c', code, '--ros-args', *(part for each in arguments for part in ('-p', each)),
            domain=self.domain)
        self.until(lambda: 'robot answers' in self.node.output and self.watch.mode == Mode.SAFE,
                   'a robot that answers')

    def furnish(self) -> None:
        """Set what is to be restored: LEDs, outputs, a song."""
        replies = (
            self.ros.call(SetLeds, 'set_leds', play=True, advance=True, power_color=77,
                          power_intensity=88),
            self.ros.call(SetDigitalOutputs, 'set_digital_outputs', output_0=True, output_2=True),
            self.ros.call(DefineSong, 'define_song', number=SONG, pitches=[60], seconds=[0.1]))
        assert all(reply.success for reply in replies), replies
        self.until(self.restored, 'LEDs and outputs')

    def end_node(self) -> None:
        """Let the node's process die."""
        _kill(self.node)

    def restored(self) -> bool:
        """Tell whether the robot is as it was set up."""
        truth = self.control.truth()
        return all(truth[name] == value for name, value in RESTORED.items())

    def standing(self) -> bool:
        """Tell whether the wheels are told to stand."""
        truth = self.control.truth()
        return bool(truth['right'] == truth['left'] == 0)

    def until(self, happened: Callable[[], Any], what: str) -> float:
        """Return after how many seconds something has happened; TimeoutError if it does not."""
        begun = looked = time.monotonic()
        if happened():
            return 0.0

        def over() -> bool:
            nonlocal looked
            now = time.monotonic()
            if now - looked < LOOK_EVERY:
                return False
            looked = now
            if now - begun > PATIENCE:
                raise TimeoutError(f'{what} did not come within {PATIENCE:g} s')
            return bool(happened())
        self.ros.until(over, what)
        return time.monotonic() - begun

    def rest(self, seconds: float) -> None:
        """Let time pass, listening."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() >= end, 'the end of a rest')

    def drive(self, linear: float, angular: float) -> None:
        """Drive until the robot has taken its speed, then say nothing more."""
        command = Twist(linear=Vector3(x=linear), angular=Vector3(z=angular))
        timer = self.ros.node.create_timer(0.05, lambda: self._velocity.publish(command))
        try:
            self.until(lambda: self.control.truth()['speed'] > linear / 2, 'driving')
        finally:
            self.ros.node.destroy_timer(timer)

    def say(self, twist: Twist) -> None:
        """Publish one velocity."""
        self._velocity.publish(twist)

    def close(self) -> None:
        """End everything, in the order that `Scene.close` explains."""
        self.ros.close()
        self.end_node()
        self.end_robot()


QUICK = ('--guess', 'boot_seconds=0')
"""A robot whose boot loader takes no time, where that is not the point."""


def _kill(program: Program | None) -> None:
    if program is not None:
        if program.running():
            os.kill(program.pid, signal.SIGKILL)
        program.ended()


_domains = 0


def _next_domain() -> int:
    global _domains
    _domains += 1
    return _domains % 100 + 1


@contextmanager
def staged(folder: Path) -> Iterator[Stage]:
    """Set a stage in a ROS domain of its own."""
    with domain_coordinator.domain_id(_next_domain) as domain:
        stage = Stage(folder, domain)
        try:
            yield stage
        finally:
            stage.close()
