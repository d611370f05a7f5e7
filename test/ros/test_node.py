# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The node as a process on a simulated serial port, with a subscriber in the test."""

from itertools import count
from math import nan, pi
import signal

from create_oi_msgs.msg import Bumper, Cliff, Mode, WheelDrop
from create_oi_msgs.srv import SetMode
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParameters
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState, JointState, PointCloud2
from std_srvs.srv import Trigger

from create_oi_ros import oi
from create_oi_ros.ros import messages
from create_oi_ros.ros.messages import yaw_of
from create_oi_ros.ros.topics import LATCHED, PUBLISHED
from support.loop import turn_difference
from support.ros import Scene, scene
from tf2_msgs.msg import TFMessage


@pytest.fixture
def stage(tmp_path):
    """Return an empty scene."""
    with scene(tmp_path) as made:
        yield made


def in_mode(modes: list[Mode], mode: int) -> bool:
    """Return whether the newest `mode` message has this mode."""
    return bool(modes) and modes[-1].mode == mode


def drive(stage: Scene, linear: float, angular: float, done) -> None:
    """Publish a velocity ten times a second until a condition is true."""
    velocity = stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    command = Twist(linear=Vector3(x=linear), angular=Vector3(z=angular))
    timer = stage.ros.node.create_timer(0.1, lambda: velocity.publish(command))
    stage.ros.until(done, f'driving {linear}, {angular}')
    stage.ros.node.destroy_timer(timer)
    velocity.publish(Twist())


def test_a_metre_and_a_turn_agree_with_the_truth(stage):
    robot = stage.robot()
    stage.node(robot.link)
    odom = stage.ros.listen(Odometry, 'odom')
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE))
    drive(stage, 0.3, 0.0, lambda: robot.body.truth().pose.x >= 1.0)
    stage.ros.until(lambda: robot.body.truth().speed == 0)
    drive(stage, 0.0, 1.5, lambda: robot.body.truth().turned >= 2 * pi)
    stage.ros.until(lambda: robot.body.truth().rate == 0)
    seen = len(odom)
    stage.ros.until(lambda: len(odom) > seen + 4)
    truth, last = robot.body.truth().pose, odom[-1]
    assert last.pose.pose.position.x == pytest.approx(truth.x, abs=0.02)
    assert last.pose.pose.position.y == pytest.approx(truth.y, abs=0.02)
    assert turn_difference(yaw_of(last.pose.pose.orientation), truth.yaw) < 0.05
    assert (last.header.frame_id, last.child_frame_id) == ('odom', 'base_footprint')


def test_every_topic_of_the_table_is_published_with_its_type(stage):
    robot = stage.robot()
    stage.node(robot.link)
    heard = {topic.name: stage.ros.listen(topic.type, topic.name, topic.qos)
             for topic in PUBLISHED}
    stage.ros.until(lambda: all(heard.values()), 'a message on every topic')


def test_stamps_rise_and_are_recent(stage):
    robot = stage.robot()
    stage.node(robot.link)
    odom = stage.ros.listen(Odometry, 'odom', 100)
    stage.ros.until(lambda: len(odom) > 50)
    stamps = [message.header.stamp.sec + message.header.stamp.nanosec / 1e9 for message in odom]
    assert stamps == sorted(stamps)
    now = stage.ros.node.get_clock().now().nanoseconds / 1e9
    assert 0 < now - stamps[-1] < 5


def nanoseconds(message) -> int:
    """Return the stamp of a message."""
    return message.header.stamp.sec * 10 ** 9 + message.header.stamp.nanosec


def test_with_use_sim_time_nothing_is_published_before_the_clock_and_stamps_follow_it(stage):
    robot = stage.robot()
    node = stage.node(robot.link, use_sim_time=True)
    heard = {topic.name: stage.ros.listen(topic.type, topic.name, topic.qos)
             for topic in PUBLISHED if topic.name != '/tf'}
    stage.ros.until(lambda: node.output.count('no time comes on /clock') == 2, 'two warnings')
    assert not any(heard.values())
    assert robot.create.mode is oi.Mode.SAFE
    ticks, clock = count(1), stage.ros.node.create_publisher(Clock, '/clock', 1)
    newest = [0]

    def tick() -> None:  # half as fast as time
        newest[0] = next(ticks) * 5_000_000
        clock.publish(Clock(clock=messages.time(newest[0])))
    stage.ros.node.create_timer(0.01, tick)
    stage.ros.until(lambda: all(heard.values()) and len(heard['odom']) > 50, 'all topics')
    for received in heard.values():
        stamps = [nanoseconds(each) for each in received]
        assert stamps == sorted(stamps)
        assert 0 < stamps[0] and stamps[-1] <= newest[0]
    assert len({nanoseconds(each) for each in heard['odom']}) == len(heard['odom'])


def test_topics_of_a_frame_have_its_stamp(stage):
    robot = stage.robot()
    stage.node(robot.link)
    transforms = stage.ros.listen(TFMessage, '/tf', 1000)
    others = {name: stage.ros.listen(type_, name, qos) for name, type_, qos in (
        ('contacts', PointCloud2, 10), ('mode', Mode, LATCHED), ('bumper', Bumper, 10))}
    stage.ros.until(lambda: transforms and others['contacts'] and in_mode(others['mode'], 2))
    robot.body.force(bump_left=1, drop_left=1)
    stage.ros.until(lambda: others['contacts'][-1].width and in_mode(others['mode'], 1))
    newest = max(nanoseconds(received[-1]) for received in others.values())
    stage.ros.until(lambda: nanoseconds(transforms[-1].transforms[0]) > newest)
    known = {nanoseconds(each.transforms[0]) for each in transforms}
    assert {nanoseconds(received[-1]) for received in others.values()} <= known


def test_what_touches_the_robot_is_published(stage):
    robot = stage.robot()
    stage.node(robot.link)
    bumps = stage.ros.listen(Bumper, 'bumper')
    drops = stage.ros.listen(WheelDrop, 'wheel_drop')
    cliffs = stage.ros.listen(Cliff, 'cliff')
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE) and bumps and drops and cliffs)
    robot.body.force(bump_left=1)
    stage.ros.until(lambda: bumps[-1].left and not bumps[-1].right)
    robot.body.force(cliff_front_right=1)
    stage.ros.until(lambda: cliffs[-1].front_right and not cliffs[-1].left)
    robot.body.drop(caster=True)
    stage.ros.until(lambda: drops[-1].caster and not drops[-1].left)
    stage.ros.until(lambda: in_mode(modes, Mode.PASSIVE))
    assert 'caster' in modes[-1].reason
    assert modes[-1].wanted == Mode.SAFE


def test_the_battery_keeps_its_contract(stage):
    robot = stage.robot()
    stage.node(robot.link)
    batteries = stage.ros.listen(BatteryState, 'battery_state')
    stage.ros.until(lambda: batteries)
    battery = batteries[-1]
    assert 12 < battery.voltage < 18
    assert battery.current < 0
    assert 0 <= battery.percentage <= 1
    assert battery.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
    robot.body.plug_charger(True)
    stage.ros.until(lambda: batteries[-1].power_supply_status
                    == BatteryState.POWER_SUPPLY_STATUS_CHARGING)


def test_wheels_turn_in_joint_states_and_tf_follows(stage):
    robot = stage.robot()
    stage.node(robot.link)
    joints = stage.ros.listen(JointState, 'joint_states')
    transforms = stage.ros.listen(TFMessage, '/tf')
    stage.ros.until(lambda: joints and transforms)
    drive(stage, 0.3, 0.0, lambda: joints[-1].position[0] > 5)
    assert list(joints[-1].name) == ['left_wheel_joint', 'right_wheel_joint']
    moved = transforms[-1].transforms[0]
    assert (moved.header.frame_id, moved.child_frame_id) == ('odom', 'base_footprint')
    assert moved.transform.translation.x > 0.1


def commanded_once(stage, robot):
    """Publish one velocity, wait until the robot drives, and return the publisher."""
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE))
    velocity = stage.ros.node.create_publisher(Twist, 'cmd_vel', 1)
    stage.ros.until(velocity.get_subscription_count)
    velocity.publish(Twist(linear=Vector3(x=0.2)))
    stage.ros.until(lambda: robot.body.truth().speed > 0.1)
    return velocity


def test_the_watchdog_stops_the_wheels(stage):
    robot = stage.robot()
    stage.node(robot.link)
    commanded_once(stage, robot)
    stage.ros.until(lambda: robot.body.truth().speed == 0)


def test_a_velocity_that_is_not_a_number_is_refused_and_stops(stage):
    robot = stage.robot()
    node = stage.node(robot.link, cmd_vel_timeout=10.0)
    velocity = commanded_once(stage, robot)
    velocity.publish(Twist(angular=Vector3(z=nan)))
    stage.ros.until(lambda: robot.body.truth().speed == 0)
    stage.ros.until(lambda: 'not finite' in node.output)


def test_velocities_drive_whatever_node_namespace_and_topic_are_called(stage):
    robot = stage.robot()
    stage.node(robot.link, '__node:=mine', '__ns:=/robot1', 'cmd_vel:=/drive')
    velocity = stage.ros.node.create_publisher(Twist, 'drive', 1)

    def drives() -> bool:
        velocity.publish(Twist(linear=Vector3(x=0.2)))
        return robot.body.truth().speed > 0.1
    stage.ros.until(drives)
    names = stage.ros.node.get_node_names_and_namespaces()
    assert {('mine', '/robot1'), ('mine_cmd_vel', '/robot1')} <= set(names)


def test_stamped_velocities_drive(stage):
    robot = stage.robot()
    stage.node(robot.link, cmd_vel_type='stamped')
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE))
    velocity = stage.ros.node.create_publisher(TwistStamped, 'cmd_vel', 1)
    stage.ros.until(velocity.get_subscription_count)
    velocity.publish(TwistStamped(twist=Twist(linear=Vector3(x=0.2))))
    stage.ros.until(lambda: robot.body.truth().speed > 0.1)


@pytest.mark.parametrize('mode', [oi.Mode.PASSIVE, oi.Mode.FULL])
def test_set_mode_answers_when_the_robot_is_in_it(stage, mode):
    robot = stage.robot()
    stage.node(robot.link)
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE))
    reply = stage.ros.call(SetMode, 'set_mode', mode=mode)
    assert reply.success, reply.message
    assert robot.create.mode is mode


@pytest.mark.parametrize('mode', [0, 4, 255])
def test_a_wrong_mode_is_refused_with_what_is_allowed(stage, mode):
    robot = stage.robot()
    stage.node(robot.link)
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE))
    reply = stage.ros.call(SetMode, 'set_mode', mode=mode)
    assert not reply.success
    assert 'SAFE' in reply.message
    assert robot.create.mode is oi.Mode.SAFE


def test_stop_and_reset_odometry(stage):
    robot = stage.robot()
    stage.node(robot.link, cmd_vel_timeout=10.0)
    odom = stage.ros.listen(Odometry, 'odom')
    drive(stage, 0.2, 0.0, lambda: odom and odom[-1].pose.pose.position.x > 0.1)
    assert stage.ros.call(Trigger, 'stop').success
    # The odometry predicts braking after a stop; the rest of it would come after the reset.
    stage.ros.until(lambda: odom[-1].twist.twist.linear.x == 0)
    assert stage.ros.call(Trigger, 'reset_odometry').success
    stage.ros.until(lambda: odom[-1].pose.pose.position.x == 0)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_the_wheels_and_leaves_passive(stage, number):
    robot = stage.robot()
    node = stage.node(robot.link, cmd_vel_timeout=10.0)
    odom = stage.ros.listen(Odometry, 'odom')
    drive(stage, 0.2, 0.0, lambda: odom and robot.body.truth().speed > 0.1)
    node.send(number)
    assert node.ended() == 0
    stage.ros.until(lambda: robot.body.truth().speed == 0)
    assert robot.create.mode is oi.Mode.PASSIVE
    assert 'Traceback' not in node.output


def test_the_node_outlives_the_robot(stage):
    robot = stage.robot()
    node = stage.node(robot.link)
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE))
    robot.close()
    stage.ros.until(lambda: in_mode(modes, Mode.UNKNOWN))
    reply = stage.ros.call(SetMode, 'set_mode', mode=Mode.SAFE)
    assert not reply.success
    stage.robot()
    stage.ros.until(lambda: in_mode(modes, Mode.SAFE))
    assert node.running()


def test_diagnostics_of_a_late_subscriber_are_of_the_last_second(stage):
    robot = stage.robot()
    stage.node(robot.link)
    odom = stage.ros.listen(Odometry, 'odom', 200)
    stage.ros.until(lambda: len(odom) > 170, 'two seconds and a half that nobody diagnosed')
    diagnostics = stage.ros.listen(DiagnosticArray, '/diagnostics')
    stage.ros.until(lambda: diagnostics)
    link = next(s for s in diagnostics[0].status if s.name.endswith('serial link'))
    values = {value.key: value.value for value in link.values}
    assert 0 < float(values['frames per second']) < 150


def test_a_port_that_is_missing_is_named_once(stage):
    node = stage.node(stage.folder / 'nothing')
    diagnostics = stage.ros.listen(DiagnosticArray, '/diagnostics')
    stage.ros.until(lambda: 'does not exist' in node.output)
    stage.ros.until(lambda: len(diagnostics) >= 3)
    assert node.output.count('does not exist') == 1
    link = next(s for s in diagnostics[-1].status if s.name.endswith('serial link'))
    assert link.level == b'\x02'


@pytest.mark.parametrize(('name', 'value', 'reason'), [
    ('mode_on_start', 'sleepy', 'passive, safe, full'),
    ('baud', 12345, '57600'),
    ('cmd_vel_timeout', 99.0, 'cmd_vel_timeout'),
    ('max_wheel_speed', 0.7, 'max_wheel_speed'),
    ('sensor_rate', 0.0, 'sensor_rate'),
    ('cmd_vel_timeout', 11, 'cmd_vel_timeout'),
])
def test_a_wrong_parameter_ends_the_node_with_the_reason(stage, name, value, reason):
    node = stage.node(stage.folder / 'create', **{name: value})
    assert node.ended() == 2
    assert reason in node.output
    assert 'Traceback' not in node.output


def test_parameters_are_described_and_refused_at_run_time(stage):
    robot = stage.robot()
    stage.node(robot.link)
    names = stage.ros.call(ListParameters, 'create/list_parameters').result.names
    ours = [name for name in names if '.' not in name and name != 'use_sim_time'
            and name != 'start_type_description_service']
    described = stage.ros.call(
        DescribeParameters, 'create/describe_parameters', names=ours).descriptors
    assert ours
    assert all(each.description for each in described)

    def attempt(name: str, value: float):
        wanted = Parameter(name=name, value=ParameterValue(
            type=ParameterType.PARAMETER_DOUBLE, double_value=value))
        return stage.ros.call(
            SetParameters, 'create/set_parameters', parameters=[wanted]).results[0]
    assert attempt('cmd_vel_timeout', 1.0).successful
    for name, value in (('cmd_vel_timeout', -1.0), ('cmd_vel_timeout', nan),
                        ('wheel_separation', 0.3)):
        refused = attempt(name, value)
        assert not refused.successful
        assert refused.reason


def test_odom_rate_thins_what_is_sent_and_may_change_at_run_time(stage):
    robot = stage.robot()
    stage.node(robot.link, odom_rate=20.0)
    odoms = stage.ros.listen(Odometry, 'odom')
    joints = stage.ros.listen(JointState, 'joint_states')

    def mean_step(received: list) -> float:
        stamps = [each.header.stamp.sec + each.header.stamp.nanosec / 1e9 for each in received]
        return (stamps[-1] - stamps[0]) / (len(stamps) - 1)

    stage.ros.until(lambda: len(odoms) > 40 and len(joints) > 40)
    assert mean_step(odoms) == pytest.approx(1 / 20, rel=0.04)
    assert mean_step(joints) == pytest.approx(1 / 20, rel=0.04)
    every_frame = Parameter(name='odom_rate', value=ParameterValue(
        type=ParameterType.PARAMETER_DOUBLE, double_value=0.0))
    reply = stage.ros.call(SetParameters, 'create/set_parameters', parameters=[every_frame])
    assert reply.results[0].successful
    odoms.clear()
    stage.ros.until(lambda: len(odoms) > 40)
    assert mean_step(odoms) == pytest.approx(oi.SLOT, rel=0.04)
