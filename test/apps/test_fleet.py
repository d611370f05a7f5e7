# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_fleet`: several robots in one process, each on its own."""

import signal

from create_oi_msgs.msg import Mode
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
import pytest

from create_oi_ros import oi
from create_oi_ros.apps import fleet
from create_oi_ros.ros.topics import LATCHED
from support.ros import Listener, Program, Robot

NAMES = ('robot1', 'robot2')


class TwoRobots:
    """Two robots, and what is heard of them."""

    def __init__(self, stage) -> None:
        self.ros: Listener = stage.ros
        self.robots: list[Robot] = [stage.robot(name) for name in NAMES]
        self.folder = stage.folder
        self.odom = [self.ros.listen(Odometry, f'{name}/odom') for name in NAMES]
        self.modes = [self.ros.listen(Mode, f'{name}/mode', LATCHED) for name in NAMES]
        self._start = stage.program

    def begin(self, *ros_arguments: str) -> Program:
        """Start the fleet; wait until both robots can be driven."""
        program = self._start(
            'create_fleet', *(f'{name}={self.folder / name}' for name in NAMES), *ros_arguments)
        self.ros.until(lambda: all(self.odom) and all(
            heard and heard[-1].mode == Mode.SAFE for heard in self.modes), 'two robots')
        return program

    def drive(self, *names: str) -> None:
        """Drive some of them forwards until their wheels are asked to turn; then go on."""
        for name in names:
            velocity = self.ros.node.create_publisher(Twist, f'{name}/cmd_vel', 1)
            self.ros.node.create_timer(
                0.1, lambda to=velocity: to.publish(Twist(linear=Vector3(x=0.2))))
        self.ros.until(lambda: all(
            self.asked(NAMES.index(name)) > 100 for name in names), f'{names} drive')

    def asked(self, index: int) -> float:
        """Return what the right wheel of a robot is asked for, mm/s."""
        return self.robots[index].create.actuators.wheels[0]

    def all_told_to_stop(self) -> bool:
        """Whether both robots are asked to stand, and are in Passive."""
        return all(robot.create.mode is oi.Mode.PASSIVE and not any(robot.create.actuators.wheels)
                   for robot in self.robots)


@pytest.fixture
def two(stage):
    """Return two robots on the floor, without a driver."""
    return TwoRobots(stage)


def test_each_robot_obeys_its_own_commands_and_a_lost_one_leaves_the_others_alone(two):
    program = two.begin()
    two.drive('robot2')
    two.ros.until(lambda: two.odom[1][-1].pose.pose.position.x > 0.05)
    assert two.asked(0) == 0
    assert two.odom[0][-1].pose.pose.position.x == 0.0
    for name, heard in zip(NAMES, two.odom):
        assert heard[-1].header.frame_id == f'{name}/odom'
        assert heard[-1].child_frame_id == f'{name}/base_footprint'
    two.robots[0].unplug()
    two.ros.until(lambda: two.modes[0][-1].mode == Mode.UNKNOWN)
    seen = len(two.odom[1])
    two.ros.until(lambda: len(two.odom[1]) > seen + 20)
    assert two.asked(1) > 100
    two.robots[0].plug()
    two.ros.until(lambda: two.modes[0][-1].mode == Mode.SAFE, 'it is found again')
    program.send(signal.SIGTERM)
    assert program.ended() == 0, program.output
    assert two.all_told_to_stop()


def test_all_stop_when_the_process_dies(two):
    program = two.begin()
    two.drive(*NAMES)
    program.send(signal.SIGKILL)
    two.ros.until(two.all_told_to_stop, 'the dead-men stop both')


def test_a_parameter_file_has_parts_for_each_robot_and_for_all(two, tmp_path):
    file = tmp_path / 'class.yaml'
    file.write_text('/**:\n  ros__parameters: {mode_on_exit: full, port: /dev/none}\n'
                    '/robot2/create:\n  ros__parameters: {mode_on_exit: safe}\n')
    program = two.begin('--ros-args', '--params-file', str(file))
    program.send(signal.SIGINT)
    assert program.ended() == 0, program.output
    assert [robot.create.mode for robot in two.robots] == [oi.Mode.FULL, oi.Mode.SAFE]


def test_simulated_robots_need_no_ports(stage):
    program = stage.program('create_fleet', '--simulated', '2')
    odom = [stage.ros.listen(Odometry, f'{name}/odom') for name in NAMES]
    stage.ros.until(lambda: all(odom), 'two robots')
    program.send(signal.SIGINT)
    assert program.ended() == 0, program.output
    assert f'export ROS_DOMAIN_ID={stage.domain}' in program.output


@pytest.mark.parametrize(('arguments', 'words'), [
    ([], 'give NAME=PORT for each robot, or --simulated COUNT'),
    (['a=/dev/x', '--simulated', '2'], 'give NAME=PORT for each robot, or --simulated COUNT'),
    (['--simulated', '0'], "'0'; allowed: 1 to 20 robots"),
    (['/dev/ttyUSB0'], "'/dev/ttyUSB0' has no port: write NAME=PORT, such as robot1=/dev/ttyUSB0"),
    (['1=/dev/ttyUSB0'], "'1' cannot be a namespace: allowed are letters, digits and _"),
    (['a=/dev/x', 'a=/dev/y'], '2 robots have the name a: each needs its own'),
    (['a=/dev/x', 'b=/dev/x'], '2 robots have the port /dev/x: each needs its own'),
])
def test_wrong_arguments_are_refused_with_what_is_allowed(capsys, arguments, words):
    with pytest.raises(SystemExit) as ended:
        fleet.parse(arguments)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_a_port_may_be_a_url():
    assert fleet.parse(['a=socket://host:1234?x=1', '--ros-args', '-p', 'baud:=0']).members == [
        fleet.Member('a', 'socket://host:1234?x=1')]
