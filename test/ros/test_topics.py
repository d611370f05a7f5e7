# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What is published for a frame: values, order, rates; and how velocity commands are heard."""

from collections.abc import Iterator
from math import hypot, isnan, pi, sqrt
import threading
from typing import Any

from create_oi_msgs.msg import (
    Bumper,
    Buttons,
    CargoBay,
    Charging,
    Cliff,
    IrOmni,
    Mode,
    Overcurrent,
    Song,
    Wall,
    WheelDrop,
)
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
import pytest
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data, QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rclpy.topic_endpoint_info import TopicEndpointInfo
from sensor_msgs.msg import BatteryState, Imu, JointState

from create_oi_ros import oi
from create_oi_ros.driver import Moved
from create_oi_ros.driver.contacts import Contacts, LEFT_BEHIND, OUTSIDE
from create_oi_ros.driver.stream import ALL
from create_oi_ros.odometry import Estimate
from create_oi_ros.robot import BODY_RADIUS
from create_oi_ros.ros.parameters import Parameters
from create_oi_ros.ros.publishing import FramePublisher, FrameTopic
from create_oi_ros.ros.topics import ALL_TOPICS, LATCHED, SENSOR_TOPICS
from create_oi_ros.ros.velocity import driver_type, RELIABLE_CHECKS, VelocityInput
from support.ros import Listener, Scene, TIMEOUT
from tf2_msgs.msg import TFMessage

QUIET = dict.fromkeys(ALL, 0)
FULL = QUIET | {
    'infrared': 137, 'bumps_and_wheel_drops': 0b10110, 'buttons': 4, 'overcurrents': 0b10001,
    'wall': 1, 'wall_signal': 4000, 'virtual_wall': 1,
    'cliff_front_left': 1, 'cliff_front_left_signal': 17, 'digital_inputs': 0b10101,
    'analog_signal': 1023, 'charging_state': 2, 'charging_sources': 2, 'song_number': 3,
    'song_playing': 1, 'voltage': 16234, 'current': -512, 'battery_temperature': 21,
    'battery_charge': 1300, 'battery_capacity': 2600}
PERIOD = 0.2


def arrived(stage: Scene, moved: Moved, *types: type) -> list[Any]:
    """Publish a frame until a message of each type has arrived; return the newest."""
    names = {topic.type: topic.name for topic in ALL_TOPICS}
    heard = [stage.ros.listen(each, names[each]) for each in types]
    parameters = Parameters(gyro='analog', sensor_rate=66.0)
    publisher = FramePublisher(stage.ros.node, parameters)

    def all_arrived() -> bool:
        nonlocal moved
        moved = moved._replace(stamp=moved.stamp + oi.SLOT)
        publisher.publish(moved, parameters)
        return all(heard)
    stage.ros.until(all_arrived, 'a message of each')
    return [each[-1] for each in heard]


def test_pose_speed_and_covariances_have_their_places_and_the_rest_is_not_measured(stage):
    estimate = Estimate(
        x=1.5, y=-2.25, yaw=pi / 2, linear=0.125, angular=-0.75,
        pose_covariance=(0.1, 0.2, 0.3, 0.2, 0.5, 0.6, 0.3, 0.6, 0.9),
        twist_covariance=(0.01, 0.02), left_wheel=11.0, right_wheel=12.0,
        left_wheel_speed=0.5, right_wheel_speed=0.25, gyro=(0.375, 0.0625))
    odom, tf, joints, imu = arrived(
        stage, Moved(0.0, oi.Readings(QUIET), estimate), Odometry, TFMessage, JointState, Imu)
    half, most = pytest.approx(sqrt(0.5)), 1e6
    pose, twist = odom.pose.pose, odom.twist.twist
    assert (odom.header.frame_id, odom.child_frame_id) == ('odom', 'base_footprint')
    assert (pose.position.x, pose.position.y, pose.position.z) == (1.5, -2.25, 0.0)
    assert (pose.orientation.z, pose.orientation.w) == (half, half)
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.125, 0.0, -0.75)
    assert list(odom.pose.covariance) == [
        0.1, 0.2, 0.0, 0.0, 0.0, 0.3,
        0.2, 0.5, 0.0, 0.0, 0.0, 0.6,
        0.0, 0.0, most, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, most, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, most, 0.0,
        0.3, 0.6, 0.0, 0.0, 0.0, 0.9]
    assert {place: each for place, each in enumerate(odom.twist.covariance) if each} == {
        0: 0.01, 7: 1e-4, 14: most, 21: most, 28: most, 35: 0.02}
    moved = tf.transforms[0]
    assert (moved.header.frame_id, moved.child_frame_id) == ('odom', 'base_footprint')
    assert moved.header.stamp.sec > 0
    assert (moved.transform.translation.x, moved.transform.translation.y) == (1.5, -2.25)
    assert (moved.transform.rotation.z, moved.transform.rotation.w) == (half, half)
    assert joints.name == ['left_wheel_joint', 'right_wheel_joint']
    assert (list(joints.position), list(joints.velocity)) == ([11.0, 12.0], [0.5, 0.25])
    assert (imu.angular_velocity.z, imu.angular_velocity_covariance[8]) == (0.375, 0.0625)
    assert imu.orientation_covariance[0] == imu.linear_acceleration_covariance[0] == -1


def test_every_reading_has_its_field(stage):
    kinds = (IrOmni, Wall, Cliff, CargoBay, Charging, Song, BatteryState, Bumper, WheelDrop,
             Buttons, Overcurrent)
    assert set(kinds) == {topic.type for topic in SENSOR_TOPICS}, 'a new topic has its values here'
    beam, wall, cliff, bay, charging, song, battery, bumper, drop, buttons, overcurrent = (
        arrived(stage, Moved(0.0, oi.Readings(FULL), Estimate()), *kinds))
    assert (beam.character, beam.name) == (137, 'remote_pause')
    assert (wall.wall, wall.virtual_wall, wall.signal) == (True, True, 4000)
    assert (cliff.left, cliff.front_left, cliff.front_left_signal) == (False, True, 17)
    assert [bay.input_0, bay.input_1, bay.input_2, bay.input_3] == [True, False, True, False]
    assert bay.baud_rate_pin and bay.analog == 5
    assert (charging.state, charging.home_base, charging.internal_charger) == (2, True, False)
    assert (song.number, song.playing) == (3, True)
    assert (battery.voltage, battery.current) == pytest.approx((16.234, -0.512))
    assert battery.percentage == 0.5 and isnan(battery.design_capacity)
    assert (bumper.left, bumper.right) == (True, False)
    assert (drop.right, drop.left, drop.caster) == (True, False, True)
    assert (buttons.play, buttons.advance) == (False, True)
    assert (overcurrent.left_wheel, overcurrent.right_wheel) == (True, False)
    assert (overcurrent.driver_0, overcurrent.driver_1) == (False, True)


@pytest.mark.parametrize('topic', SENSOR_TOPICS, ids=lambda topic: topic.name)
def test_a_row_of_a_topic_names_all_readings_that_its_message_is_made_from(topic):
    arrived = oi.Readings(dict.fromkeys((*topic.watch, *topic.needs), 0))
    topic.fill(topic.type(check_fields=True), arrived)


@pytest.mark.parametrize('topic', SENSOR_TOPICS, ids=lambda topic: topic.name)
@pytest.mark.parametrize('unknown', [0, None])
def test_a_message_that_is_filled_again_keeps_nothing_of_the_frame_before(topic, unknown):
    later = oi.Readings.of_fields({
        name: unknown if name.endswith(('_signal', '_charge')) else 0 for name in FULL})
    again, once = topic.type(), topic.type()
    topic.fill(again, oi.Readings(FULL))
    assert str(again) != str(once), 'it has something to keep'
    topic.fill(again, later)
    topic.fill(once, later)
    assert str(again) == str(once)  # NaN does not equal itself


class Frames:
    """Publishes frames one by one, a slot apart, and collects the topics of each."""

    def __init__(self, stage, monkeypatch) -> None:
        for topic in ((Odometry, 'odom'), (Bumper, 'bumper'), (Cliff, 'cliff'),
                      (Buttons, 'buttons')):
            stage.ros.listen(*topic)
        self._slot = 0
        self.odom_rate = 0.0
        self._told: list[str] = []
        publish = FrameTopic.publish

        def tell(topic: FrameTopic, *frame: Any) -> None:
            self._told.append(topic.publisher.msg_type.__name__)
            publish(topic, *frame)
        monkeypatch.setattr(FrameTopic, 'publish', tell)
        self.publisher = FramePublisher(stage.ros.node, Parameters())
        stage.ros.until(lambda: {'Odometry', 'Bumper', 'Cliff'} <= set(self.next()))

    @property
    def stamp(self) -> float:
        """Stamp of the newest frame, s."""
        return self._slot * oi.SLOT

    def next(self, **readings: int) -> list[str]:
        """Return the topics of a frame, in order; readings that are not given are zero."""
        self._told.clear()
        self._slot += 1
        self.publisher.publish(
            Moved(self.stamp, oi.Readings(QUIET | readings), Estimate()),
            Parameters(sensor_rate=1 / PERIOD, odom_rate=self.odom_rate))
        self.nanoseconds = self.publisher.stamps.newest
        return self._told

    def quiet(self) -> None:
        """Publish frames until the periodic sensor topics have just been published."""
        while 'Bumper' not in self.next():
            pass


@pytest.fixture
def frames(stage, monkeypatch):
    """Return frames after one in which every topic was published."""
    return Frames(stage, monkeypatch)


def test_a_change_comes_before_the_odometry_and_at_once(frames):
    frames.quiet()
    assert frames.next() == ['Odometry']
    assert frames.next(bumps_and_wheel_drops=1) == ['Bumper', 'Odometry']
    assert frames.next(bumps_and_wheel_drops=1) == ['Odometry']
    frames.quiet()
    assert frames.next(cliff_left=1) == ['Cliff', 'Odometry']
    assert frames.next(cliff_left=1, song_playing=1) == ['Song', 'Odometry']
    assert frames.next() == ['Cliff', 'Song', 'Odometry']


@pytest.mark.parametrize('rate', [0, 20, 66])
def test_odometry_comes_at_its_rate_and_a_topic_that_always_changes_delays_no_other(frames, rate):
    frames.odom_rate = rate
    frames.quiet()
    told = [list(frames.next(bumps_and_wheel_drops=(slot + 1) % 2)) for slot in range(1000)]
    assert all(names[0] == 'Bumper' and names.count('Bumper') == 1 for names in told)
    assert not any('Buttons' in names for names in told), 'latched: only changes are published'
    assert sum('Cliff' in names for names in told) == round(1000 * oi.SLOT / PERIOD)
    assert sum('Odometry' in names for names in told) == pytest.approx(
        1000 * oi.SLOT * (rate or 1 / oi.SLOT), abs=1)


def test_with_a_simulated_clock_stamps_are_its_time_at_any_speed(frames, stage, capfd):
    stage.ros.node.set_parameters([Parameter('use_sim_time', value=True)])
    assert (frames.next(bumps_and_wheel_drops=1), frames.nanoseconds) == ([], None)
    clock = stage.ros.node.get_clock()
    stamps = []
    for speed in (1.0, 0.5, 2.0):
        for _ in range(100):
            clock.set_ros_time_override(Time(nanoseconds=clock.now().nanoseconds + round(
                speed * oi.SLOT * 1e9)))
            assert 'Odometry' in frames.next()
            assert frames.nanoseconds == clock.now().nanoseconds
            stamps.append(frames.nanoseconds)
    assert stamps == sorted(set(stamps))
    # It stands: only changes; it starts again: that is said.
    assert [list(frames.next()) for _ in range(100)] == [[]] * 100
    assert frames.next(bumps_and_wheel_drops=2) == ['Bumper']
    clock.set_ros_time_override(Time(nanoseconds=5))
    assert 'Odometry' in frames.next()
    assert frames.nanoseconds == 5
    assert 'the clock went back by 5.2' in capfd.readouterr().err


def test_only_what_is_heard_or_latched_is_published(frames):
    told = {name for wall in range(40) for name in frames.next(wall=wall % 2, buttons=wall % 2)}
    assert {'Odometry', 'Bumper', 'Cliff', 'Buttons'} <= told
    assert not told & {'Wall', 'WheelDrop', 'JointState', 'TFMessage', 'BatteryState'}


# What was felt, as points of `contacts`.


def felt(contacts: Contacts, at: Estimate, stamp: float = 0.0, **readings: int) -> Any:
    """Take a frame in; return the points, kept for two seconds."""
    contacts.update(oi.Readings(QUIET | readings), at, stamp, 2.0)
    return contacts.points(at)


@pytest.mark.parametrize(('readings', 'left'), [
    ({'bumps_and_wheel_drops': 2}, 1), ({'bumps_and_wheel_drops': 1}, -1),
    ({'bumps_and_wheel_drops': 3}, 0), ({'cliff_left': 1}, 1), ({'cliff_front_left': 1}, 1),
    ({'cliff_front_right': 1}, -1), ({'cliff_right': 1}, -1), ({'virtual_wall': 1}, 0)])
def test_each_sensor_has_a_point_just_outside_the_hull_on_its_side(readings, left):
    (x, y), = felt(Contacts(), Estimate(x=1.0, y=2.0, yaw=pi / 2), **readings)
    assert hypot(x, y) == pytest.approx(BODY_RADIUS + OUTSIDE) and x > 0
    assert y == pytest.approx(0, abs=1e-9) if left == 0 else y * left > 0


def test_a_robot_that_moves_away_leaves_what_it_felt_where_that_was():
    contacts, there = Contacts(), Estimate(x=1.0, y=2.0, yaw=pi / 2)
    assert len(felt(contacts, there, bumps_and_wheel_drops=2)) == 1
    (_, y), = felt(contacts, there, 0.015, bumps_and_wheel_drops=3)
    assert y == pytest.approx(0, abs=1e-9), 'one half came first'
    back, far = there._replace(y=1.95), BODY_RADIUS + OUTSIDE + 0.05
    assert felt(contacts, back, 0.5)[0] == pytest.approx((far, 0.0))
    assert felt(contacts, back._replace(yaw=pi), 2.0)[0] == pytest.approx((0.0, -far))
    assert felt(contacts, back, 2.1) == ()
    felt(contacts, there, 3.0, virtual_wall=1)
    assert felt(contacts, there._replace(y=2.0 - LEFT_BEHIND - 0.01), 3.1) == ()


# What comes in: velocity commands, of either type and reliability, whoever publishes them.


RELIABLE, BEST_EFFORT = QoSProfile(depth=1), qos_profile_sensor_data


class Heard:
    """A velocity input that runs, and the commands that it has heard."""

    def __init__(self, ros: Listener) -> None:
        self._ros = ros
        self._got: list[tuple[float, float]] = []
        self.input = VelocityInput(ros.node, 'auto', self._on_command, on_failure=lambda: None)
        self.input.start()

    def _on_command(self, linear: float, angular: float, stamp: Any) -> None:
        self._got.append((linear, angular))

    def until(self, publish: Any, speed: float) -> None:
        """Publish until it is heard; meanwhile the input adapts to its publishers."""
        self._got.clear()

        def heard() -> bool:
            self.input.adapt(self._ros.node.get_publishers_info_by_topic('cmd_vel'))
            publish(speed)
            return (speed, -speed) in self._got
        self._ros.until(heard)


@pytest.fixture
def heard(stage) -> Iterator[Heard]:
    """Return an input of the scene's node."""
    made = Heard(stage.ros)
    yield made
    made.input.close()


def publisher(stage: Scene, type_: type) -> Any:
    """Return a function that publishes a speed, on a context of its own: that has one type."""
    made = stage.listener('other').node.create_publisher(type_, 'cmd_vel', RELIABLE)

    def publish(speed: float) -> None:
        twist = Twist(linear=Vector3(x=speed), angular=Vector3(z=-speed))
        made.publish(twist if type_ is Twist else TwistStamped(twist=twist))
    publish.end = made.destroy  # type: ignore[attr-defined]
    return publish


def test_types_follow_the_publishers_that_are_alone_and_stay_while_both_are_there(stage, heard):
    twist = publisher(stage, Twist)
    heard.until(twist, 0.1)
    stamped = publisher(stage, TwistStamped)
    heard.until(twist, 0.2)
    twist.end()
    heard.until(stamped, 0.3)
    twist = publisher(stage, Twist)
    heard.until(stamped, 0.4)
    assert heard.input.type is TwistStamped
    stamped.end()
    heard.until(twist, 0.5)


def endpoint(qos: QoSProfile = RELIABLE, type_: str = 'Twist') -> TopicEndpointInfo:
    """Return a publisher of this type."""
    return TopicEndpointInfo(topic_type=f'geometry_msgs/msg/{type_}', qos_profile=qos)


def test_best_effort_ends_when_all_have_been_reliable_for_a_while(stage, heard):
    made = heard.input
    made.adapt([endpoint(), endpoint(BEST_EFFORT)])
    stage.ros.until(lambda: made.reliability is ReliabilityPolicy.BEST_EFFORT)
    for _ in range(2):
        for _ in range(RELIABLE_CHECKS - 1):
            made.adapt([endpoint()])
        made.adapt([])
        assert made.reliability is ReliabilityPolicy.BEST_EFFORT
        made.adapt([endpoint(BEST_EFFORT)])
    for _ in range(RELIABLE_CHECKS):
        made.adapt([endpoint()])
    stage.ros.until(lambda: made.reliability is ReliabilityPolicy.RELIABLE)
    heard.until(publisher(stage, Twist), 0.2)


def test_close_waits_for_the_function(stage):
    entered, leave, left, failed = (threading.Event() for _ in range(4))

    def take(linear: float, angular: float, stamp: Any) -> None:
        entered.set()
        assert leave.wait(TIMEOUT)
        left.set()
    made = VelocityInput(stage.ros.node, 'twist', take, on_failure=failed.set)
    never = VelocityInput(stage.ros.node, 'twist', take, on_failure=failed.set)
    made.start()
    publish = publisher(stage, Twist)
    stage.ros.until(lambda: publish(0.1) or entered.is_set())
    threading.Timer(0.1, leave.set).start()
    for each in (made, never):
        each.close()
    assert left.is_set()
    assert not failed.is_set()


# Who takes the commands: only a driver does, a node that publishes its mode.


def test_a_listener_is_no_driver_and_does_not_choose_the_type(stage):
    node = stage.ros.node
    stage.listener('recorder').listen(Twist, 'cmd_vel')
    stage.ros.until(lambda: node.count_subscribers('cmd_vel'))
    assert driver_type(node) is None
    stage.listener('create_cmd_vel').listen(TwistStamped, 'cmd_vel')
    stage.ros.until(lambda: node.count_subscribers('cmd_vel') == 2)
    assert driver_type(node) is None, 'no node create publishes its mode'
    stage.listener('create').node.create_publisher(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: driver_type(node))
    assert driver_type(node) is TwistStamped
    stage.listener('echo').listen(Twist, 'cmd_vel')
    stage.ros.until(lambda: node.count_subscribers('cmd_vel') == 3)
    assert driver_type(node) is TwistStamped
