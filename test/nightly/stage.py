# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulated robot and a node as processes, and a listener that checks what is published."""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from math import hypot, remainder, tau
from pathlib import Path
import time
from typing import Any, NamedTuple

from create_oi_msgs.msg import Mode
from create_oi_msgs.srv import DefineSong, SetDigitalOutputs, SetLeds
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from create_oi_ros.ros.messages import yaw_of
from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.ros.topics import LATCHED, SENSOR_TOPICS
from support.ros import Listener, own_domain, Program
from support.simulator import ControlClient

LOOK_EVERY = 0.01
"""Seconds between two looks at a condition."""
HELD = (
    'bump_left=0 bump_right=0 drop_left=0 drop_right=0 drop_caster=0 wall=0 wall_signal=1234 '
    'cliff_left=0 cliff_front_left=0 cliff_front_right=0 cliff_right=0 cliff_left_signal=1001 '
    'cliff_front_left_signal=2002 cliff_front_right_signal=3003 cliff_right_signal=404 '
    'virtual_wall=0 infrared=130 play=0 advance=0 charging_state=0 voltage=15123 current=-321 '
    'temperature=27 charge=2001 capacity=2702 home_base=0 internal_charger=0 digital_input_0=1 '
    'digital_input_1=0 digital_input_2=1 digital_input_3=0 analog=700')
"""A fixed value for every sensor of the robot: any other value that is published is wrong."""
SONG = 3
"""Number of the song that must survive every fault."""
LEDS = {'power_color': 77, 'power_intensity': 88}
RESTORED = {'mode': 'SAFE', 'leds': 10, 'outputs': 5, **LEDS}
"""State of the robot that must be restored after a fault, as the control socket shows it."""
QUICK = ('--guess', 'boot_seconds=0')
"""Options of a robot whose boot loader takes no time."""


class Stage:
    """One robot, one node, and one client that drives."""

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
        """The control socket of the robot."""
        assert self._control is not None
        return self._control

    def start_robot(self, *arguments: str) -> None:
        """Start a new robot and hold its sensors; only then point the port to it."""
        self._robots += 1
        link, control = self.folder / f'tty{self._robots}', self.folder / f'control{self._robots}'
        self.robot = Program('-c', PROGRAMS['create_sim'], '--link', str(link), '--control',
                             str(control), *(arguments or QUICK), domain=self.domain)
        self.until(lambda: control.exists() and 'help' in self.robot.output, 'a robot')
        self._control = ControlClient(control)
        self.control.tell(f'force {HELD}')
        new_port = self.folder / 'new_port'
        new_port.symlink_to(link)
        new_port.replace(self.port)

    def end_robot(self) -> None:
        """Kill the robot's process."""
        # A cable that is pulled out takes its device name with it; another may get that name.
        (self.folder / f'tty{self._robots}').unlink(missing_ok=True)
        if self.robot is not None:
            self.robot.close()
        if self._control is not None:
            self._control.close()

    def start_node(self, *, code: str = PROGRAMS['create_node'], **parameters: object) -> None:
        """Start the driver; wait until the robot answers and is in Safe mode."""
        self.watch.restart()
        arguments = [f'port:={self.port}', *(f'{n}:={value}' for n, value in parameters.items())]
        self.node = Program(
            '-c', code, '--ros-args', *(part for each in arguments for part in ('-p', each)),
            domain=self.domain)
        self.until(lambda: 'robot answers' in self.node.output and self.watch.mode == Mode.SAFE,
                   'a robot that answers')

    def set_outputs(self) -> None:
        """Set what the driver must restore: LEDs, outputs, a song."""
        for type_, name, fields in (
                (SetLeds, 'set_leds', {'play': True, 'advance': True, **LEDS}),
                (SetDigitalOutputs, 'set_digital_outputs', {'output_0': True, 'output_2': True}),
                (DefineSong, 'define_song', {'number': SONG, 'pitches': [60], 'seconds': [0.1]})):
            self.until(lambda: self.ros.call(type_, name, **fields).success, name)  # noqa: B023
        self.until(self.restored, 'LEDs and outputs')

    def end_node(self) -> None:
        """Kill the node's process."""
        if self.node is not None:
            self.node.close()

    def end(self) -> None:
        """End node and robot; whoever comes next starts others."""
        self.end_node()
        self.end_robot()
        self.node = self.robot = None

    def restored(self) -> bool:
        """Whether the robot's mode, LEDs and outputs are as they were set."""
        truth = self.control.truth()
        return all(truth[name] == value for name, value in RESTORED.items())

    def stopped(self) -> bool:
        """Whether zero speed is requested of both wheels."""
        truth = self.control.truth()
        return bool(truth['right'] == truth['left'] == 0)

    def until(self, happened: Callable[[], Any], what: str) -> float:
        """Wait for a condition; return how long it took, or raise AssertionError."""
        begun, looked = time.monotonic(), 0.0

        def over() -> bool:
            nonlocal looked
            if time.monotonic() - looked < LOOK_EVERY:
                return False
            looked = time.monotonic()
            return bool(happened())
        self.ros.until(over, what)
        return time.monotonic() - begun

    def wait(self, seconds: float) -> None:
        """Let time pass and receive messages."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() >= end, 'the end of a wait')

    def drive(self, linear: float, angular: float) -> None:
        """Publish a velocity until the robot has half of its speed, then no more."""
        command = Twist(linear=Vector3(x=linear), angular=Vector3(z=angular))
        timer = self.ros.node.create_timer(0.05, lambda: self._velocity.publish(command))
        try:
            self.until(lambda: self.control.truth()['speed'] > linear / 2, 'driving')
        finally:
            self.ros.node.destroy_timer(timer)

    def publish(self, twist: Twist) -> None:
        """Publish one velocity."""
        self._velocity.publish(twist)

    def close(self) -> None:
        """End everything, in the order that `Scene.close` explains."""
        self.ros.close()
        self.end_node()
        self.end_robot()


@contextmanager
def staged(folder: Path) -> Iterator[Stage]:
    """Yield a stage in a ROS domain of its own; end its processes afterwards."""
    with own_domain() as domain, closing(Stage(folder, domain)) as stage:
        yield stage


# Checks everything that a node publishes for wrong values.


STEP, TURN = 0.05, 0.15
"""Tolerance of a step of the odometry, metres and radians."""
FASTEST, FASTEST_TURN = 0.6, 5.0
"""Highest speed that the odometry may show, m/s and rad/s."""


class Pose(NamedTuple):
    """A pose and its time: seconds of the system's clock, metres, radians."""

    time: float
    x: float
    y: float
    yaw: float


def jump(before: Pose, after: Pose) -> str:
    """Return a description of a step that no robot can have made; empty if there is none."""
    seconds = after.time - before.time
    if seconds <= 0:
        return f'odom: stamps do not rise ({seconds:.3f} s)'
    way = hypot(after.x - before.x, after.y - before.y)
    turn = abs(remainder(after.yaw - before.yaw, tau))
    if way <= STEP + FASTEST * seconds and turn <= TURN + FASTEST_TURN * seconds:
        return ''
    return f'odom: {way:.3f} m, {turn:.3f} rad within {seconds:.3f} s up to {after.time:.3f}'


class Watch:
    """Subscribes to everything that a node publishes, and collects what is wrong."""

    def __init__(self, ros: Listener) -> None:
        self.wrong: list[str] = []
        self.odoms = 0
        self._ros = ros
        self._since = 0.0
        """Start of the present node: older messages are late ones of the node before it."""
        self.newest = 0.0
        """The newest stamp of an `odom`, seconds of the system's clock."""
        self._last: Pose | None = None
        self._first: dict[str, str] = {}
        for topic in SENSOR_TOPICS:
            if topic.name != 'song':
                ros.node.create_subscription(
                    topic.type, topic.name,
                    lambda message, name=topic.name: self._on_sensor(name, message), topic.qos)
        ros.node.create_subscription(Odometry, 'odom', self._on_odom, 200)
        self._modes = ros.listen(Mode, 'mode', LATCHED)

    @property
    def mode(self) -> int | None:
        """The mode that was published last."""
        return self._modes[-1].mode if self._modes else None

    def restart(self) -> None:
        """Expect another node, whose odometry begins at the origin."""
        self._last = None
        self._since = time.time()
        self._modes.clear()

    def _on_sensor(self, name: str, message: Any) -> None:
        message.header = Header()
        text = str(message)
        if text != self._first.setdefault(name, text):
            self.wrong.append(f'{name}: {text}')

    def _on_odom(self, odom: Odometry) -> None:
        pose = _pose(odom)
        if pose.time < self._since:
            return
        self.odoms += 1
        self.newest = pose.time
        if self._last is not None and (wrong := jump(self._last, pose)):
            self.wrong.append(wrong)
        self._last = pose


def _pose(odom: Odometry) -> Pose:
    stamp, at, turned = odom.header.stamp, odom.pose.pose.position, odom.pose.pose.orientation
    return Pose(stamp.sec + stamp.nanosec / 1e9, at.x, at.y, yaw_of(turned))
