# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
A robot that waits for another reason than the driver's own script.

Whether it loses or queues what it is sent meanwhile is not known: both, and queues of many sizes.
"""

from collections.abc import Iterator
from dataclasses import replace
from random import Random

import pytest

from create_oi_ros import oi
from create_oi_ros.driver import MotionLimits, Settings, Severity
from create_oi_ros.driver.goals import Dock
from create_oi_ros.driver.listening import QUESTIONS
from create_oi_ros.driver.outbox import DEAD_MAN_STOP, DRAIN, HALT, WAKE_UP
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.actuators import DARK, Lights
from create_oi_ros.sim.server.faults import DAMAGE_TO_ROBOT, Fault, Faults
from support.asking import power_cycle
from support.goals import distance, start
from support.loop import Loop, said
from support.nightly import NIGHTLY, times, UNMEASURED
from support.robot import GENTLE, Robot

QUEUES = (0, 40, 135, 256, 341, 343, 345, 1000)
"""Sizes of the robot's queue; some are full in the middle of what the driver sends."""


def waiting(tenths: int, settings: Settings | None = None, **guesses: object) -> Loop:
    """Return a robot that drives, and then waits as if damaged bytes had told it to."""
    loop = Loop(settings)
    loop.robot.guesses = replace(loop.robot.guesses, **guesses)
    loop.run(0.5)
    loop.drive(0.2, 0.0, 1.0)
    loop.heard.clear()
    loop.robot.receive(oi.WaitTime(time=tenths).encode(), loop.now)
    assert loop.robot.waiting
    return loop


@pytest.mark.parametrize('queue', [0, 256])
def test_within_a_second_of_a_wait_less_is_sent_than_any_queue_holds(queue):
    loop = waiting(8, wait_queue=queue)
    loop.drive(0.3, 0.5, 0.8)
    assert len(loop.heard) < 135
    loop.drive(0.3, 0.0, 1.0)
    assert loop.body.truth().speed == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize('queue', [0, 135, 256, 1000])
@pytest.mark.parametrize('streams', [True, False])
def test_a_robot_that_waits_for_long_is_sent_little_and_drives_after_it(queue, streams):
    loop = waiting(100, wait_queue=queue, stream_while_waiting=streams)
    loop.drive(0.2, 1.0, 9.5)
    assert loop.robot.waiting
    # The zeros that end a command harm nothing.
    assert len(loop.heard.replace(DRAIN, b'')) < (200 if streams else 300)
    loop.drive(0.2, 0.0, 3.5)
    if not streams:  # it was away: commands have to pause
        loop.run(1.0)
        loop.drive(0.2, 0.0, 1.0)
    assert not loop.robot.waiting
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.body.truth().speed == pytest.approx(0.2, abs=0.01)
    assert not loop.driver.health(loop.now).suspects_commands


@pytest.mark.parametrize('queue', QUEUES)
@pytest.mark.parametrize('tenths', [5, 31, 32])
def test_no_part_of_what_is_sent_does_harm(queue, tenths):
    """A lost beginning of Stream would leave packet 7, which restarts the robot."""
    loop = waiting(tenths, wait_queue=queue)
    restarted = []
    loop.robot.power = lambda *_: restarted.append('power')
    fastest = 0.0
    while loop.robot.waiting:
        loop.drive(0.2, 0.0, 0.1)
    loop.driver.drive(0.0, 0.0, loop.now)
    for _ in range(400):
        loop.turn()
        fastest = max(fastest, abs(loop.body.truth().speed))
    assert not restarted
    assert loop.robot.mode is oi.Mode.SAFE
    assert fastest <= 0.21
    assert loop.body.truth().speed == 0


@pytest.mark.parametrize('queue', [0, 256])
@pytest.mark.parametrize('ways', [('stop',), ('cancel',), ('cancel', 'stop')], ids=str)
def test_of_stops_while_the_robot_waits_two_are_sent_and_hold_after_it(queue, ways):
    loop = waiting(20, wait_queue=queue)
    loop.drive(0.3, 0.0, 0.5)
    assert loop.driver.health(loop.now).suspects_commands
    before = bytes(loop.heard)
    for way in 20 * ways:
        if way == 'stop':
            loop.driver.stop(loop.now)
        else:
            goal = loop.driver.goals.start(distance(0.5), loop.now)
            loop.turn()
            loop.driver.goals.cancel(goal, loop.now)
        loop.turn()
    sent = bytes(loop.heard[len(before):]).replace(WAKE_UP, b'')
    assert sent.count(bytes([HALT.opcode])) == 2
    loop.run(3.0)
    assert not loop.robot.waiting
    assert loop.body.truth().speed == 0
    assert not loop.driver.health(loop.now).suspects_commands


@pytest.mark.parametrize('queue', [0, 256])
@pytest.mark.parametrize('tenths', [5, 6, 8])
@pytest.mark.parametrize('after', [0.3, 0.4, 0.5, 0.6])
def test_a_goal_to_dock_goes_on_where_the_robot_answers_in_the_rest_before_it(
        queue, tenths, after):
    loop = waiting(tenths, wait_queue=queue)
    loop.drive(0.3, 0.0, after)
    goal = start(loop, Dock(0.0))
    loop.run(4.0)
    assert goal.outcome is None and loop.robot.demo is oi.DemoNumber.COVER_AND_DOCK
    assert not said(loop, Severity.ERROR, '')


@pytest.mark.parametrize('queue', [0, 256])
@pytest.mark.parametrize('tenths', [5, 9, 20])
def test_a_stop_is_not_gentle_where_the_robot_waits(queue, tenths):
    limits = MotionLimits(linear_acceleration=0.1)
    loop = waiting(tenths, Settings(limits=limits), wait_queue=queue)
    loop.drive(0.2, 0.0, 0.4)
    loop.commands()
    loop.driver.stop(loop.now)
    loop.run(3.5)
    assert {each.right for each in loop.commands() if isinstance(each, oi.DriveDirect)} == {0}


@pytest.mark.parametrize('phase', range(8))
def test_after_a_silence_a_robot_goes_on_to_speed_up_from_where_it_was(phase):
    loop = Loop(Settings(limits=MotionLimits(linear_acceleration=0.05)), delay=0.01)
    loop.run(0.5)
    loop.drive(0.4, 0.0, 1.0 + 0.05 * phase)
    loop.lost_down = True
    loop.drive(0.4, 0.0, 0.8)
    loop.commands()
    loop.lost_down = False
    loop.drive(0.4, 0.0, 1.0)
    sent = [each.right for each in loop.commands() if isinstance(each, oi.DriveDirect)]
    assert sent == sorted(sent) and sent[-1] > sent[0]


def test_a_wait_from_before_the_driver_started_is_met():
    loop = Loop()
    loop.robot = Create(loop.body)
    loop.robot.receive(oi.Start().encode() + oi.WaitTime(time=30).encode(), loop.now)
    loop.run(2.5)
    assert not loop.driver.state.answered
    loop.run(2.0)
    assert loop.robot.mode is oi.Mode.SAFE
    loop.drive(0.2, 0.0, 0.5)
    assert loop.body.truth().speed > 0.1


# Commands that the robot did not hear, or misheard.


@pytest.mark.parametrize('begun', [
    oi.Song(number=0, notes=(oi.Note(60, 10),) * 16).encode()[:3],
    oi.Script(script=bytes(100)).encode()[:2], bytes([oi.Stream.opcode, 255])])
def test_a_robot_in_the_middle_of_a_command_hears_a_stop_within_a_second(loop, begun):
    loop.drive(0.3, 0.0, 0.5)
    loop.robot.receive(begun, loop.now)
    loop.driver.stop(loop.now)
    loop.run(1.5)
    assert loop.body.truth().speed == 0
    assert loop.driver.state.answered


def test_a_robot_that_stands_and_waits_is_told_of_and_told_all_again_when_it_hears(loop):
    pending = loop.driver.outputs.set_leds(
        oi.Leds(bits=oi.LedBits(0), color=7, intensity=8))
    loop.run(0.5)
    assert pending.outcome.ok
    loop.robot.receive(oi.WaitTime(time=40).encode(), loop.now)
    loop.run(3.5)
    assert said(loop, Severity.ERROR, 'ignores commands') == 1
    assert not loop.driver.stop(loop.now).outcome.ok
    loop.robot.actuators.lights = DARK
    loop.run(2.5)
    assert not loop.driver.health(loop.now).ignores_commands
    assert loop.robot.actuators.lights == Lights(oi.LedBits(0), 7, 8)
    assert loop.driver.stop(loop.now).outcome == (True, 'stop sent')


def test_a_robot_that_was_told_to_wait_is_well_after_it_was_switched_off_and_on(loop):
    loop.drive(0.3, 0.0, 0.5)
    loop.robot.receive(oi.WaitEvent(event=oi.Event.PLAY_BUTTON).encode(), loop.now)
    loop.run(3.0)
    assert said(loop, Severity.ERROR, 'switch it off and on') == 1
    power_cycle(loop)
    assert loop.robot.mode is oi.Mode.SAFE
    assert not loop.driver.health(loop.now).ignores_commands
    assert loop.body.truth().speed == 0


def test_a_robot_that_waits_once_it_has_answered_is_told_of(loop):
    """It sends the list of a call, and nothing else since it waits."""
    loop.drive(0.3, 0.0, 0.5)
    call, wait = oi.Stream(packets=QUESTIONS[0].ids), oi.WaitEvent(event=oi.Event.PLAY_BUTTON)
    loop.robot.receive(call.encode() + wait.encode(), loop.now)
    loop.drive(0.2, 0.0, 3.0)
    assert said(loop, Severity.ERROR, 'switch it off and on') == 1
    assert loop.driver.status.actual is None
    power_cycle(loop)
    assert loop.robot.mode is oi.Mode.SAFE
    assert loop.body.truth().speed == 0


class DamagedLoop(Loop):
    """Damages a part of what the robot is sent, of each kind."""

    faults = Faults([])

    def _carry(self, line, data):
        if line is self._up and data:
            data = self.faults.to_robot(data, self.now)
        super()._carry(line, data)


def follows_after_damage(seed: int) -> bool:
    """Tell whether a robot drives that was sent damaged bytes, or the user is told what to do."""
    loop, random = DamagedLoop(Settings(baud=0), robot_baud=57600), Random(seed)
    loop.robot.guesses = replace(loop.robot.guesses, boot_seconds=0.0)
    loop.run(0.5)
    loop.drive(random.uniform(0.1, 0.4), random.uniform(-1.0, 1.0), 0.5)
    loop.run(random.uniform(0.0, 0.2))
    loop.faults = Faults([Fault(kind, 0.1) for kind in DAMAGE_TO_ROBOT], seed)
    until = loop.now + random.uniform(0.5, 2.0)
    while loop.now < until:
        loop.drive(random.uniform(-0.4, 0.4), 0.0, 0.05)
    loop.faults = Faults([])
    until = loop.now + 6.0
    while loop.now < until and loop.robot.actuators.right != 50:
        loop.driver.drive(0.0, 0.0, loop.now)
        loop.drive(0.05, 0.0, 0.1)
    return loop.robot.actuators.right == 50 or any(
        said(loop, Severity.ERROR, words) for words in ('switch it off and on', 'no answer at'))


@pytest.mark.parametrize('seeds', [
    (5, 402), (767, 1094, 1470, 1667, 1678, 2054), range(6, 14),
    pytest.param(range(3000, 3000 + times(1000)), marks=[NIGHTLY, UNMEASURED])],
    ids=['infrared only', 'garbage', 'any', 'many'])
def test_whatever_a_robot_was_sent_it_follows_again_or_the_user_is_told_what_to_do(seeds):
    assert not [seed for seed in seeds if not follows_after_damage(seed)]


# A robot that waits for the rest of a command: what stops it, and how soon.


BYTE = oi.PacketList((7,)).budget(57600).seconds / oi.PacketList((7,)).frame_size
"""Seconds that a byte takes."""
AT_ONCE, DRAINED = 0.003, 0.06
"""Seconds until the wheels stand, for commands of known and of counted length."""


def cuts(command: type[oi.Command]) -> Iterator[bytes]:
    """Yield all beginnings of commands with this opcode, for some data bytes."""
    for data in (0, 1, 16, 100, 254):
        begun = bytes([command.opcode])
        while len(begun) < min(command.size(begun), 40):
            yield begun
            begun += bytes([data])


def turning_after(begun: bytes, words: bytes) -> float:
    """Return the seconds after which the wheels of a robot that drove are asked for zero."""
    robot = Robot(oi.Mode.FULL)
    robot.say(GENTLE)
    robot.create.receive(begun, robot.now)
    last = 0.0
    for count, byte in enumerate(words, 1):
        robot.say(bytes([byte]))
        robot.run(BYTE)
        if robot.wheels != (0, 0):
            last = count * BYTE
    return last


WAITS = [command for command in oi.COMMANDS if command.title.startswith('Wait ')]
OTHERS = [command for command in oi.COMMANDS if command not in WAITS]
words = pytest.mark.parametrize('words', [WAKE_UP, DEAD_MAN_STOP], ids=['wake up', 'last words'])


@words
@pytest.mark.parametrize('command', OTHERS, ids=lambda command: command.title)
def test_wheels_stop_whatever_command_was_cut_short(command, words):
    counted = command.size(bytes([command.opcode, 255, 255])) > 8
    soon = DRAINED if counted else AT_ONCE
    for begun in cuts(command):
        assert turning_after(begun, words) < soon, begun.hex(' ')


@words
@pytest.mark.parametrize('command', WAITS, ids=lambda command: command.title)
def test_a_wait_that_was_cut_short_waits_as_the_page_says(command, words):
    """No bytes end it: they would have to be few for Wait, and none of these for Baud."""
    waits = turning_after(bytes([command.opcode]), words) > DRAINED / 2
    assert waits is (command is not oi.WaitEvent)
