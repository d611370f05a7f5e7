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
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import get_typestore, Stores
from std_msgs.msg import Header

from create_oi_ros.ros import messages, topics
from create_oi_ros.ros.serialized import filled, locate, SerializedMessage

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
    assert brought == filled(message, values)


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
