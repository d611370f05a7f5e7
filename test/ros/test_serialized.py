# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Serialized messages: whatever is packed, a subscriber gets what an object would have brought."""

from collections.abc import Iterable, Iterator
import itertools
import struct
from typing import Any

from create_oi_msgs.msg import Bumper, Cliff, IrOmni
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
import pytest
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.time import Time
from rosbags.typesys import get_typestore, Stores
from std_msgs.msg import Header

from create_oi_ros import oi
from create_oi_ros.driver import Moved
from create_oi_ros.driver.stream import ALL
from create_oi_ros.odometry import Estimate
from create_oi_ros.ros import messages, publishing, topics
from create_oi_ros.ros.parameters import Parameters
from create_oi_ros.ros.publishing import FramePublisher
from create_oi_ros.ros.serialized import locate, SerializedMessage, set_fields

FRAMES = st.text(st.characters(min_codepoint=1, max_codepoint=0x2fff), max_size=40)
EMPTY: dict[type, Any] = {
    topics.ODOM.type: messages.empty_odometry, topics.TF.type: messages.empty_transforms,
    topics.JOINT_STATES.type: lambda *_: messages.empty_joint_states()}
TYPES = sorted({topic.type for topic in topics.PUBLISHED} - {topics.DIAGNOSTICS.type},
               key=lambda type_: type_.__name__)


def empty(type_: type, frame: str, other: str) -> Any:
    """Return the message of a topic as the node makes it."""
    if type_ in EMPTY:
        return EMPTY[type_](frame, other)
    return type_(header=Header(frame_id=frame))


def numbers(message: Any, path: str = '') -> Iterator[str]:
    """Yield the paths of all numbers in a message."""
    for name in message.get_fields_and_field_types():
        inside, found = f'{path}.{name}'.lstrip('.'), getattr(message, name)
        if hasattr(found, 'get_fields_and_field_types'):
            yield from numbers(found, inside)
        elif isinstance(found, bool | int | float):
            yield inside
        elif not isinstance(found, str):
            for index, each in enumerate(found):
                if hasattr(each, 'get_fields_and_field_types'):
                    yield from numbers(each, f'{inside}[{index}]')
                elif not isinstance(each, str):
                    yield f'{inside}[{index}]'


def value(code: str) -> st.SearchStrategy[Any]:
    """Return values of a number with this code of `struct`."""
    bits = 8 * struct.calcsize(code)
    if code == '?':
        return st.booleans()
    if code in 'fd':
        return st.floats(allow_nan=False, width=bits)
    return (st.integers(-(1 << bits - 1), (1 << bits - 1) - 1) if code.islower()
            else st.integers(0, (1 << bits) - 1))


def serialized(message: Any, paths: Iterable[str]) -> SerializedMessage:
    """Return a message as bytes, through rclpy."""
    return SerializedMessage(message, list(paths), serialize_message, deserialize_message)


@pytest.mark.parametrize('type_', TYPES)
@settings(max_examples=25)
@given(drawn=st.data())
def test_a_subscriber_gets_what_an_object_would_have_brought(type_, drawn):
    message = empty(type_, drawn.draw(FRAMES), drawn.draw(FRAMES))
    paths = drawn.draw(st.lists(st.sampled_from(list(numbers(message))), min_size=1, unique=True))
    encode = serialized(message, paths)
    places: dict[str, tuple[str, int]] = {}
    locate(message, type_.__name__, '', 0, places)
    values = {path: drawn.draw(value(places[path][0])) for path in paths}
    in_another_order = dict(reversed(values.items()))
    brought = deserialize_message(encode(in_another_order), type_)
    assert brought == set_fields(message, values)


def test_what_is_no_number_of_the_message_or_does_not_fit_is_refused():
    encode = serialized(Cliff(), ['left_signal'])
    with pytest.raises(struct.error):
        encode({'left_signal': 1 << 16})
    with pytest.raises(KeyError):
        encode({'right_signal': 1})
    with pytest.raises(ValueError, match='name is no number'):
        serialized(IrOmni(), ['character', 'name'])


@pytest.mark.parametrize('wrong', [
    lambda text: text[:4] + bytes(4) + text[4:],
    lambda text: text[:4] + bytes(8) + text[4:],
    lambda text: b'\0\0' + text[2:],  # the other byte order
    lambda text: text[:-8],
])
def test_a_middleware_that_serializes_otherwise_is_found_out(wrong):
    with pytest.raises(ValueError, match='do not say what was packed'):
        SerializedMessage(
            Odometry(), ['pose.pose.position.x'],
            lambda message: wrong(serialize_message(message)), deserialize_message)


def test_a_type_that_is_not_used_is_refused():
    with pytest.raises(ValueError, match='data is of type wstring'):
        locate('text', 'wstring', 'data', 0, {})


def test_what_stands_in_the_gaps_between_fields_may_differ():
    counted = itertools.count()

    def noisy(message: Any) -> bytes:
        text = bytearray(serialize_message(message))
        text[18] = next(counted)  # behind the two bytes of the frame
        return bytes(text)
    message = Odometry(header=Header(frame_id='a'))
    encode = SerializedMessage(message, ['pose.pose.position.x'], noisy, deserialize_message)
    brought = deserialize_message(encode({'pose.pose.position.x': 2.5}), Odometry)
    assert brought.pose.pose.position.x == 2.5


def test_a_middleware_that_reads_otherwise_is_found_out():
    def swapped(received: bytes, type_: type) -> Any:
        message = deserialize_message(received, type_)
        message.left, message.right = message.right, message.left
        return message
    with pytest.raises(ValueError, match='do not say what was packed'):
        SerializedMessage(Bumper(), ['left', 'right'], serialize_message, swapped)


@pytest.mark.parametrize('type_', [
    type_ for type_ in TYPES if not type_.__module__.startswith('create_oi')])
def test_a_strict_reader_of_bags_reads_the_bytes(type_):
    message = empty(type_, 'odom', 'base')
    paths = [path for path in numbers(message) if 'stamp' in path]
    package, name = type_.__module__.partition('.')[0], type_.__name__
    read = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(
        serialized(message, paths)(dict(zip(paths, itertools.count(1)))), f'{package}/msg/{name}')
    header = read.transforms[0].header if name == 'TFMessage' else read.header
    assert (header.stamp.sec, header.stamp.nanosec) == (1, 2)


# What is published for a frame.


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
