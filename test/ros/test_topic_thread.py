# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Subscriptions without an executor: with a thread of their own, or taken by whoever looks."""

from collections.abc import Callable, Iterator
from contextlib import closing
import threading

import pytest
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from std_msgs.msg import Int32

from create_oi_ros.ros.polled_topic import PolledTopic
from create_oi_ros.ros.topic_thread import TopicThread
from support.ros import Listener, own_domain, TIMEOUT


@pytest.fixture
def ros() -> Iterator[Listener]:
    """Return a node in a domain of its own."""
    with own_domain() as domain, closing(Listener(domain)) as made:
        yield made


@pytest.fixture
def publish(ros) -> Callable[[int], None]:
    """Return a function that publishes a number to whoever has subscribed."""
    publisher = ros.node.create_publisher(Int32, 'number', 1)

    def publish_number(number: int) -> None:
        ros.until(publisher.get_subscription_count)
        publisher.publish(Int32(data=number))
    return publish_number


@pytest.fixture
def failed() -> threading.Event:
    """Return what is set when the thread has ended with an error."""
    return threading.Event()


@pytest.fixture
def subscribe(ros, failed) -> Iterator[Callable[[Callable[[Int32], None]], TopicThread]]:
    """Return a function that subscribes to `number`; all are closed at the end."""
    made: list[TopicThread] = []

    def subscribe_with(callback: Callable[[Int32], None]) -> TopicThread:
        made.append(TopicThread(ros.node, Int32, 'number', callback, on_failure=failed.set))
        return made[-1]
    yield subscribe_with
    for each in made:
        each.close()


def test_messages_come_without_an_executor(subscribe, publish, failed):
    received, came = [], threading.Event()

    def take(message: Int32) -> None:
        received.append((message.data, threading.current_thread()))
        came.set()
    thread = subscribe(take)
    thread.start()
    for number in (1, 2):
        came.clear()
        publish(number)
        assert came.wait(TIMEOUT)
    assert [data for data, _ in received] == [1, 2]
    assert received[0][1] not in (threading.current_thread(), threading.main_thread())
    assert not failed.is_set()


def test_raw_messages_come_as_bytes(ros, publish):
    received, came = [], threading.Event()

    def take(message: bytes) -> None:
        received.append(message)
        came.set()
    with closing(TopicThread(
            ros.node, Int32, 'number', take, on_failure=came.set, raw=True)) as thread:
        thread.start()
        publish(7)
        assert came.wait(TIMEOUT)
    assert received == [serialize_message(Int32(data=7))]


def test_an_executor_leaves_its_messages_alone(ros, subscribe, publish):
    taken: list[int] = []
    subscribe(lambda message: taken.append(message.data))  # and never started
    heard = ros.listen(Int32, 'number')
    publish(1)
    ros.until(lambda: heard)
    assert taken == []


def test_close_ends_it_while_it_waits_and_twice_and_unstarted(subscribe, failed):
    never, thread = subscribe(lambda message: None), subscribe(lambda message: None)
    thread.start()
    for each in (never, thread):
        each.close()
    assert not [each for each in threading.enumerate() if each.name == 'number']
    assert not failed.is_set()


def test_close_waits_for_the_function(subscribe, publish):
    entered, leave, left = threading.Event(), threading.Event(), threading.Event()

    def take(message: Int32) -> None:
        entered.set()
        assert leave.wait(TIMEOUT)
        left.set()
    thread = subscribe(take)
    thread.start()
    publish(0)
    assert entered.wait(TIMEOUT)
    threading.Timer(0.1, leave.set).start()
    thread.close()
    assert left.is_set()


def test_an_error_in_the_function_is_told_and_printed(subscribe, publish, failed, monkeypatch):
    printed: list[threading.ExceptHookArgs] = []
    monkeypatch.setattr(threading, 'excepthook', printed.append)

    def take(message: Int32) -> None:
        raise ValueError(f'{message.data} is wrong')
    thread = subscribe(take)
    thread.start()
    publish(7)
    assert failed.wait(TIMEOUT)
    thread.close()
    assert [str(each.exc_value) for each in printed] == ['7 is wrong']


def test_a_polled_topic_passes_on_what_has_come_and_no_more_than_it_keeps(ros):
    taken: list[int] = []
    polled = PolledTopic(
        ros.node, Int32, 'number', lambda message: taken.append(message.data), QoSProfile(depth=3))
    heard = ros.listen(Int32, 'number')
    publisher = ros.node.create_publisher(Int32, 'number', 10)
    polled.take()
    assert taken == []
    for number in range(5):
        publisher.publish(Int32(data=number))
    ros.until(lambda: len(heard) == 5)
    assert taken == [], 'the executor leaves them alone'
    polled.take()
    assert taken == [2, 3, 4]
    polled.take()
    assert taken == [2, 3, 4]
