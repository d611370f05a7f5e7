# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""A robot that waits for the rest of a command: what stops it, and how soon."""

from collections.abc import Iterator

import pytest

from create_oi_ros import oi
from create_oi_ros.driver.outbox import DEAD_MAN_STOP, WAKE_UP
from support.robot import GENTLE, Robot

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
def test_a_song_that_takes_the_stop_for_its_length_ends_within_the_drain(words):
    assert turning_after(bytes([oi.Song.opcode, 0]), words) < DRAINED


@words
@pytest.mark.parametrize('command', WAITS, ids=lambda command: command.title)
def test_a_wait_that_was_cut_short_waits_as_the_page_says(command, words):
    """No bytes end it: they would have to be few for Wait, and none of these for Baud."""
    waits = turning_after(bytes([command.opcode]), words) > DRAINED / 2
    assert waits is (command is not oi.WaitEvent)
