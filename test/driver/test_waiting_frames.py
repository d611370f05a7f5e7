# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Frames that say nothing new wait; all that follows from them is the same, and no news waits."""

from collections.abc import Callable
from random import Random

from hypothesis import given
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.driver import Moved
from create_oi_ros.driver.stream_plan import StreamPlan
from create_oi_ros.driver.waiting_frames import NOISY, WaitingFrames
from create_oi_ros.link.session import Session
from create_oi_ros.sim.body.config import BodyConfig
from support.loop import AT_ONCE, STEP
from support.patient_loop import PatientLoop

PATIENCE = 0.1
SHORT = StreamPlan(57600).short
VALUES = dict.fromkeys(SHORT.names, 0) | {'oi_mode': 2, 'wall_signal': 300}


def frame(packets: oi.PacketList = SHORT, **values: int) -> oi.Frame:
    """Return a frame of a robot that stands, but for these values."""
    data = packets.pack_frame([(VALUES | values)[name] for name in packets.names])
    return oi.Frame(packets, data, oi.Checksum.HARDWARE)


def waiting(room: int = 3, until: float = 10.0) -> WaitingFrames:
    """Return what lets frames wait that say what a standing robot's does."""
    made = WaitingFrames()
    made.let(frame(), b'', room, until)
    return made


@pytest.mark.parametrize('name', SHORT.names)
def test_news_of_any_packet_does_not_wait_but_noise_does(name):
    assert waiting().keep(frame(**{name: VALUES[name] + 1}).data, 1.0) == (name in NOISY)


@given(values=st.fixed_dictionaries({name: st.integers(0, 4095) for name in NOISY}))
def test_no_noise_is_news(values):
    assert waiting().keep(frame(**values).data, 1.0)


@given(place=st.integers(0, SHORT.frame_size - 1), damage=st.integers(1, 255))
def test_a_damaged_frame_does_not_wait(place, damage):
    data = bytearray(frame().data)
    data[place] ^= damage
    assert not waiting().keep(bytes(data), 1.0)


@given(cuts=st.sets(st.integers(1, 3 * SHORT.frame_size - 1)), begun=st.integers(0, 20))
def test_pieces_of_frames_wait_up_to_the_one_with_news(cuts, begun):
    stream = b''.join(frame(wall_signal=signal).data for signal in range(3))
    values = frame(wall_signal=2, bumps_and_wheel_drops=1).data
    different = min(at for at, (one, other) in enumerate(zip(values, frame(wall_signal=2).data))
                    if one != other)
    changed = stream[:-len(values)] + values
    for data, first in ((stream, len(stream)), (changed, 2 * len(values) + different)):
        frames = WaitingFrames()
        frames.let(frame(), data[:begun], 3, 10.0)
        ends = [begun, *sorted(cut for cut in cuts if cut > begun), len(data)]
        for begin, end in zip(ends, ends[1:]):
            kept = frames.keep(data[begin:end], 1.0)
            assert kept == (end <= first)
            if not kept:
                break


def test_frames_wait_up_to_a_number_and_a_moment_and_keep_order_and_time():
    frames = waiting(room=2, until=10.0)
    kept = [frames.keep(frame(wall_signal=at).data, float(at)) for at in (9, 10, 10)]
    assert kept == [True, True, False]
    assert frames.take() == [(frame(wall_signal=at).data, float(at)) for at in (9, 10)]
    assert not frames.take()
    assert not frames.keep(frame().data, 9.0)  # until it is allowed again
    assert not waiting(until=10.0).keep(frame().data, 10.1)


def test_nothing_waits_before_it_is_allowed_and_after_it_is_forbidden():
    assert not WaitingFrames().keep(frame().data, 1.0)
    frames = waiting()
    frames.forbid()
    assert not frames.keep(frame().data, 1.0)


def both(act: Callable[[PatientLoop], None], **options) -> tuple[PatientLoop, PatientLoop]:
    """Do the same with a host that wants each frame, and one that wants some."""
    loops = PatientLoop(0.0, **options), PatientLoop(PATIENCE, **options)
    for loop in loops:
        act(loop)
        loop.run(3 * PATIENCE)
        loop.driver.catch_up()
        loop.report()
    return loops


def wander(loop: PatientLoop) -> None:
    """Drive in turns and straight, and stand, for two minutes."""
    random = Random(5)
    for _ in range(12):
        loop.drive(random.uniform(-0.3, 0.3), random.choice((0.0, 1.0, -0.7)), 7.0)
        loop.drive(0.0, 0.0, 3.0)


@pytest.mark.parametrize('options', [
    {}, {'config': BodyConfig()}, {'in_pieces': True}], ids=['ideal', 'default', 'in pieces'])
def test_estimates_and_commands_are_those_of_a_host_that_looks_at_each_frame(options):
    eager, patient = both(wander, **options)
    assert patient.moved == eager.moved
    assert patient.heard == eager.heard
    assert patient.looks < 0.6 * eager.looks


def test_a_robot_that_stands_is_looked_at_when_its_place_is_wanted():
    eager, patient = both(lambda loop: loop.run(30.0))
    assert patient.moved == eager.moved
    assert patient.looks < 0.25 * eager.looks


def first_told(loop: PatientLoop, said: Callable[[oi.Readings], bool]) -> float:
    """Return when the host was told first of a frame that says something."""
    return next(at for at, event in loop.told if isinstance(event, Moved) and said(event.readings))


@pytest.mark.parametrize('name', ['bump_left', 'cliff_right', 'wall', 'play'])
def test_news_is_told_at_once_after_what_waited(name):
    def act(loop: PatientLoop) -> None:
        loop.run(10.0)
        loop.body.force(**{name: 1})
        loop.run(0.5)

    def said(readings: oi.Readings) -> bool:
        return bool(readings.has('buttons') and (
            readings.bumps_and_wheel_drops or readings.cliff_right or readings.wall
            or readings.buttons))
    eager, patient = both(act)
    assert first_told(patient, said) == first_told(eager, said)
    assert patient.moved == eager.moved


def test_the_watchdog_stops_the_wheels_as_soon():
    def act(loop: PatientLoop) -> None:
        loop.drive(0.2, 0.0, 10.0)
        loop.heard.clear()
        while oi.DriveDirect(right=0, left=0) not in loop.commands():
            loop.run(STEP)
    eager, patient = both(act)
    assert patient.now == eager.now


def test_a_new_speed_is_taken_in_at_the_same_time():
    def act(loop: PatientLoop) -> None:
        loop.driver.set_limits(AT_ONCE)
        loop.drive(0.2, 0.0, 10.03)
        loop.drive(-0.2, 0.5, 5.02)
    eager, patient = both(act)
    assert patient.moved == eager.moved
    assert patient.heard == eager.heard


def waits() -> PatientLoop:
    """Return a loop of a robot that drives, while frames wait."""
    loop = PatientLoop(PATIENCE)
    loop.drive(0.2, 0.0, 10.0)
    while loop.kept < 2:
        loop.turn()
    return loop


@pytest.mark.parametrize('use', [
    lambda session: session.request().__enter__(), Session.counts, Session.health,
    Session.close], ids=['request', 'counts', 'health', 'close'])
def test_a_session_takes_in_what_waits_before_anything_else(use):
    loop = waits()
    session = Session(loop.driver, 'nowhere', on_event=lambda event: None,
                      on_failure=lambda: None, dead_man=False)
    frames = loop.driver.counts.frames
    use(session)
    assert loop.driver.counts.frames == frames + loop.kept


def test_health_counts_what_waits():
    loop = PatientLoop(PATIENCE)
    loop.run(10.0)
    eager = PatientLoop(0.0)
    eager.run(10.0)
    assert loop.driver.health(loop.now).counts == eager.driver.health(eager.now).counts
    assert loop.driver.health(loop.now).frame_age < 2 * oi.SLOT


@pytest.mark.parametrize('end', ['disconnected', 'shut_down'])
def test_what_waits_at_the_end_is_not_lost(end):
    def act(loop: PatientLoop) -> None:
        loop.drive(0.2, 0.0, 10.05)
        if end == 'disconnected':
            loop.driver.disconnected('unplugged')
        else:
            loop.driver.shut_down(loop.now)
    eager, patient = both(act)
    assert patient.moved == eager.moved
