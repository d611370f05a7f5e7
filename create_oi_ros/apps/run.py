"""
`create_run`: a robot and its node in one terminal, with a status line every second.

Without `--port` the robot is a simulated one on a pseudo terminal.
"""

import argparse
from math import degrees
import os
from pathlib import Path
from shlex import quote
import shutil
import sys
import tempfile

from create_oi_msgs.msg import Mode
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.task import Future
from sensor_msgs.msg import BatteryState

from ..ros.children import Children
from ..ros.messages import mode_name
from ..ros.process import call_on_signal, ros_executor, spin_until
from ..ros.rotation import yaw_of
from ..ros.topics import LATCHED


class StatusNode(Node):
    """Subscribes to the driver's topics and prints a status line every second."""

    def __init__(self, children: Children, ended: Future) -> None:
        """Watch the children too: when one ends by itself, `ended` gets exit code 1."""
        super().__init__('create_run')
        self._ended = ended
        self._children = children
        self._frames = 0
        self._odom: Odometry | None = None
        self._mode: Mode | None = None
        self._battery: BatteryState | None = None
        self._link: dict[str, str] = {}
        self.create_subscription(Odometry, 'odom', self._on_odom, 10)
        self.create_subscription(Mode, 'mode', self._on_mode, LATCHED)
        self.create_subscription(BatteryState, 'battery_state', self._on_battery, 10)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        self.create_timer(1.0, self._print)

    def _on_odom(self, odom: Odometry) -> None:
        self._odom = odom
        self._frames += 1

    def _on_mode(self, mode: Mode) -> None:
        self._mode = mode

    def _on_battery(self, battery: BatteryState) -> None:
        self._battery = battery

    def _on_diagnostics(self, diagnostics: DiagnosticArray) -> None:
        for status in diagnostics.status:
            if status.name.endswith('serial link'):
                self._link = {value.key: value.value for value in status.values}

    def _print(self) -> None:
        ended = self._children.ended()
        if ended is not None:
            print(f'create_run: {ended}; see above for why', file=sys.stderr)
            self._ended.set_result(1)
            return
        print('  '.join((
            f'{self._frames:3d} frames/s', self._mode_text(), self._odom_text(),
            self._battery_text(),
            f'faults {self._link.get("damaged frames", "-")} frames '
            f'{self._link.get("garbage bytes", "-")} bytes')), flush=True)
        self._frames = 0

    def _mode_text(self) -> str:
        if self._mode is None:
            return 'no node yet'
        reason = f' ({self._mode.reason})' if self._mode.reason else ''
        return f'{mode_name(self._mode.mode):7s}{reason}'

    def _odom_text(self) -> str:
        if self._odom is None:
            return 'no odometry yet'
        pose, twist = self._odom.pose.pose, self._odom.twist.twist
        yaw = degrees(yaw_of(pose.orientation))
        return (f'x {pose.position.x:+.3f} m  y {pose.position.y:+.3f} m  yaw {yaw:+6.1f} deg  '
                f'{twist.linear.x:+.2f} m/s  {twist.angular.z:+.2f} rad/s')

    def _battery_text(self) -> str:
        if self._battery is None:
            return 'battery -'
        return f'battery {self._battery.voltage:.1f} V {self._battery.percentage:.0%}'


def introduction(port: str, simulated: bool) -> str:
    """Return what runs and what to try next, with commands that work on this machine."""
    robot = 'a simulated Create' if simulated else 'the robot'
    lines = [
        f'create_run: node /create drives {robot} on {port}, '
        f'ROS domain {os.environ.get("ROS_DOMAIN_ID", "0")}.']
    environment = os.environ.get('CREATE_OI_ENV')
    if environment is not None:
        example = quote(str(Path(environment).parent / 'examples' / 'drive.py'))
        environment = quote(environment)
        lines += ['In another shell, drive it and watch its odometry:',
                  f'    source {environment} && python {example}',
                  'or look at it, and drive it by keys:',
                  f'    source {environment} && create_view']
    if shutil.which('ros2') is not None:
        lines += ['Watch a topic, or drive by keyboard:', '    ros2 topic echo /bumper',
                  '    ros2 run create_oi_ros create_view']
    return '\n'.join([*lines, 'Ctrl-C stops the robot and everything here.'])


def _watch(children: Children, ended: Future) -> int:
    with ros_executor() as executor:
        executor.add_node(StatusNode(children, ended))
        spin_until(executor, ended)
        # Before ROS shuts down: the robot may be moving.
        children.end()
    return int(ended.result())


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='create_run', description=__doc__)
    parser.add_argument('--port', help='serial device of a real robot; default: a simulated one')
    parser.add_argument('--world', default='room', help='world of the simulated robot')
    parser.add_argument('--capture', metavar='FILE', help=(
        'write every byte of the serial line to FILE, to be sent with a bug report'))
    return parser


def main() -> int:
    """Run until Ctrl-C; the exit code is 1 when a child ended by itself."""
    arguments = _arguments().parse_args()
    children, ended = Children(), Future()
    call_on_signal(lambda: ended.set_result(0))
    with tempfile.TemporaryDirectory(prefix='create-') as folder:
        port = arguments.port or f'{folder}/create'
        print(introduction(port, arguments.port is None), flush=True)
        try:
            if arguments.port is None:
                children.start('create_sim', '--link', port, '--world', arguments.world)
            capture = ['-p', f'capture:={arguments.capture}'] if arguments.capture else []
            children.start('create_node', '--ros-args', '-p', f'port:={port}', *capture)
            return _watch(children, ended)
        finally:
            children.end()
