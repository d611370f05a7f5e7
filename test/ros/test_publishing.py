# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Which messages are published for a frame, and in which order: changes first."""

from create_oi_msgs.msg import Bumper, Cliff
from nav_msgs.msg import Odometry
import pytest
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rclpy.time import Time

from create_oi_ros import oi
from create_oi_ros.driver import Moved
from create_oi_ros.driver.stream import ALL
from create_oi_ros.odometry import Estimate
from create_oi_ros.ros import publishing
from create_oi_ros.ros.parameters import Parameters
from create_oi_ros.ros.publishing import FramePublisher

QUIET = dict.fromkeys(ALL, 0)
PERIOD = 0.2


class Frames:
    """Publishes frames one by one, a slot apart, and collects the topics of each."""

    def __init__(self, stage, monkeypatch) -> None:
        for topic in (Odometry, 'odom'), (Bumper, 'bumper'), (Cliff, 'cliff'):
            stage.ros.listen(*topic)
        self._slot = 0
        self.motion_period = 0.0
        self._told: list[str] = []
        really = publishing.encoder

        def encoder(log, message, example):
            encode = really(log, message, example)

            def tell(values):
                self._told.append(type(message).__name__)
                return encode(values)
            return tell
        monkeypatch.setattr(publishing, 'encoder', encoder)
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
        self.nanoseconds = self.publisher.publish(
            Moved(self.stamp, oi.Readings(QUIET | readings), Estimate()),
            PERIOD, self.motion_period)
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


def test_what_is_due_again_comes_behind_the_odometry_in_its_period(frames):
    frames.quiet()
    told = [list(frames.next()) for _ in range(200)]
    assert all(names[0] == 'Odometry' for names in told)
    for name in ('Bumper', 'Cliff'):
        assert sum(name in names for names in told) == round(200 * oi.SLOT / PERIOD)


def test_a_topic_that_changes_in_each_frame_comes_once_and_delays_no_other(frames):
    frames.quiet()
    told = [list(frames.next(bumps_and_wheel_drops=(slot + 1) % 2)) for slot in range(200)]
    assert all(names.count('Bumper') == 1 for names in told)
    assert sum('Cliff' in names for names in told) == round(200 * oi.SLOT / PERIOD)


@pytest.mark.parametrize('rate', [20, 66])
def test_with_odom_rate_odometry_comes_at_its_rate_and_changes_at_once(frames, rate):
    frames.motion_period = 1 / rate
    frames.quiet()
    told = [list(frames.next(bumps_and_wheel_drops=(slot + 1) % 2)) for slot in range(1000)]
    assert all(names[0] == 'Bumper' for names in told)
    assert sum('Odometry' in names for names in told) == pytest.approx(
        1000 * oi.SLOT * rate, abs=1)


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


def test_where_bytes_cannot_be_packed_objects_are_published_with_one_warning(
        stage, monkeypatch, capfd):
    monkeypatch.setattr(
        publishing, 'serialize_message', lambda message: serialize_message(message)[:-8])
    heard = stage.ros.listen(Odometry, 'odom')
    frames = FramePublisher(stage.ros.node, Parameters())
    slots = iter(range(100000))

    def publish() -> bool:
        moved = Moved(next(slots) * oi.SLOT, oi.Readings(QUIET), Estimate(x=3.5))
        frames.publish(moved, 1.0, 0.0)
        return bool(heard)
    stage.ros.until(publish)
    assert heard[-1].pose.pose.position.x == 3.5
    assert capfd.readouterr().err.count('Odometry: its bytes do not say ') == 1
