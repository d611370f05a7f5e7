# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Power, buttons and the serial port of the simulated Create, one test for each sentence.

Sections Physical Connections, Serial Port Settings and Baud.
"""

from collections.abc import Callable
from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

from create_oi_ros import oi
from create_oi_ros.oi import Mode
from create_oi_ros.sim.firmware.guesses import Guesses, parse_guesses
from create_oi_ros.sim.world import shipped
from support.robot import GENTLE, Robot
import vectors

ASK_MODE = bytes([142, 35])


def booted(robot: Robot) -> Robot:
    """Switch a robot off and on, and wait until it hears."""
    robot.create.power(False, robot.now)
    robot.create.power(True, robot.now)
    robot.run(3.1)
    return robot


# Serial Port Settings.

@pytest.mark.parametrize('ends', [
    booted, lambda robot: robot.create.lose_battery(robot.now)], ids=['power', 'battery'])
def test_a_rate_lasts_until_the_power_is_turned_off_or_the_battery_removed(
        ends: Callable[[Robot], object]) -> None:
    robot = Robot(Mode.PASSIVE)
    robot.say(oi.Baud(code=7))
    assert robot.create.baud == 19200
    ends(robot)
    assert robot.create.baud == 57600


def test_the_battery_voltage_below_the_minimum_turns_the_robot_off() -> None:
    robot = Robot(Mode.FULL)
    robot.body.set_battery(charge=0)
    robot.slots()
    assert not robot.create.powered
    robot.create.power(True, robot.now)
    assert not robot.create.powered
    robot.body.set_battery(charge=0.5)
    robot.create.power(True, robot.now)
    robot.run(4)
    robot.say(oi.Start())
    assert robot.mode is Mode.PASSIVE


# Baud.

@pytest.mark.parametrize(('code', 'rate'), vectors.BAUD_CODES.items())
def test_baud_sets_the_rate_according_to_its_code(code: int, rate: int) -> None:
    robot = Robot(Mode.PASSIVE)
    robot.say(bytes([129, code]))
    robot.run(0.2)
    assert robot.create.baud == rate
    assert robot.say(ASK_MODE, baud=rate) == b'\x01'


def test_you_must_wait_100_ms_after_sending_baud() -> None:
    robot = Robot(Mode.PASSIVE)
    assert robot.say(bytes([129, 7]) + ASK_MODE) == b''
    robot.run(0.08)
    assert robot.say(ASK_MODE, baud=19200) == b''
    robot.run(0.04)
    assert robot.say(ASK_MODE, baud=19200) == b'\x01'


@pytest.mark.parametrize('rate', [19200, 38400, 115200])
def test_a_host_that_listens_at_the_wrong_rate_receives_garbage(rate: int) -> None:
    robot = Robot(Mode.PASSIVE)
    robot.say(bytes([148, 1, 35]))
    robot.create.host_baud(rate)
    said = robot.run(1.5)
    assert said
    assert bytes([19, 2, 35, 1]) not in said


def test_at_115200_bytes_too_close_together_may_be_lost() -> None:
    for overrun, answer in ((False, b'\x01'), (True, b'')):
        robot = Robot(Mode.PASSIVE, guesses=Guesses(overrun=overrun))
        robot.say(bytes([129, 11]))
        robot.run(0.2)
        assert robot.say(ASK_MODE) == answer


# Physical Connections: power.

def test_a_robot_that_is_off_neither_hears_nor_speaks_nor_moves() -> None:
    robot = Robot(Mode.FULL)
    robot.say(bytes([148, 1, 7]), GENTLE)
    robot.run(1)
    robot.create.power(False, robot.now)
    robot.create.data_to_send()
    assert robot.say(oi.Start(), ASK_MODE) == b''
    assert robot.run(2) == b''
    assert robot.speed == 0
    assert robot.create.lights == (0, 0, 0)


def test_at_power_on_it_says_some_140_bytes_of_ascii() -> None:
    robot = Robot()
    robot.create.power(False, robot.now)
    robot.create.power(True, robot.now)
    banner = robot.run(1)
    assert 130 < len(banner) < 150
    assert banner.isascii()
    assert b'RDK by iRobot!' in banner


def test_opcode_7_restarts_the_robot() -> None:
    robot = Robot(Mode.FULL)
    assert b'RDK by iRobot!' in robot.say(bytes([7]))
    assert robot.mode is Mode.OFF
    robot.run(4)
    assert robot.say(oi.Start(), ASK_MODE) == b'\x01'


def test_banner_boot_time_and_opcode_7_are_guesses_with_switches() -> None:
    plain = Guesses(banner=False, boot_seconds=0.0, opcode_7_resets=False)
    robot = Robot(Mode.FULL, guesses=plain)
    assert robot.say(bytes([7]) + ASK_MODE) == b'\x03'
    robot.create.power(False, robot.now)
    robot.create.power(True, robot.now)
    assert robot.say(oi.Start(), ASK_MODE) == b'\x01'


def test_songs_scripts_and_requests_are_forgotten_at_power_off() -> None:
    robot = Robot(Mode.FULL)
    robot.say(oi.Song(number=0, notes=(oi.Note(60, 64),)), oi.Script(script=b'\x99'), GENTLE)
    booted(robot)
    robot.create.data_to_send()
    assert robot.say(oi.Start(), oi.Full(), bytes([154])) == b'\0'
    robot.say(oi.PlaySong(number=0))
    assert not robot.read('song_playing')
    assert robot.ask(41, 42) == bytes(4)


# Buttons.

@pytest.mark.parametrize('mode', [Mode.OFF, Mode.PASSIVE])
def test_advance_chooses_a_demo_and_play_plays_and_stops_it(mode: Mode) -> None:
    robot = Robot(mode)
    for button in ('advance', 'advance', 'play'):
        robot.body.force(seconds=0.1, **{button: 1})
        robot.run(0.5)
    assert robot.create.demo is oi.DemoNumber.SPOT_COVER
    robot.body.force(seconds=0.1, play=1)
    robot.run(2)
    assert (robot.create.demo, robot.speed, robot.mode) == (None, 0, mode)


def test_guesses_are_read_from_text_and_refused_with_the_reason() -> None:
    _, guesses = parse_guesses(['boot_seconds=0.5', 'banner=false', 'transmit_buffer=64'])
    assert guesses == Guesses(boot_seconds=0.5, banner=False, transmit_buffer=64)
    for text in ('boot=1', 'banner=2', 'boot_seconds=-1', 'boot_seconds=x', 'transmit_buffer=1.5',
                 'boot_seconds=nan', 'boot_seconds=inf', ''):
        with pytest.raises(ValueError, match='allowed|not a number'):
            parse_guesses([text])


# Any bytes.


AT_ONCE = Guesses(opcode_7_resets=False, boot_seconds=0.0)
OPCODES = st.sampled_from([kind.opcode for kind in oi.COMMANDS])
BYTES = st.lists(st.integers(0, 255) | OPCODES, max_size=60).map(bytes)


@given(st.lists(st.tuples(BYTES, st.floats(0, 0.5), st.sampled_from([None, 300, 57600, 115200])),
                max_size=8),
       st.sampled_from(list(Mode)), st.booleans())
@settings(max_examples=100)
def test_no_bytes_raise(
        sent: list[tuple[bytes, float, int | None]], mode: Mode, resets: bool) -> None:
    robot = Robot(mode, world=shipped('table'), guesses=Guesses(
        opcode_7_resets=resets, boot_seconds=0.1, overrun=resets))
    for data, seconds, baud in sent:
        robot.say(data, baud=baud)
        robot.run(seconds)
    assert robot.mode in Mode


def test_a_robot_recovers_from_any_bytes_by_harmless_ones() -> None:
    """As a driver does on connecting: at most 2 + 2 * 255 bytes end any incomplete command."""
    random = Random(7)
    for _ in range(200):
        robot = Robot(Mode.PASSIVE, guesses=AT_ONCE)
        robot.say(bytes([140, 0, 255]) + random.randbytes(random.randrange(20)))
        robot.say(bytes(600), oi.Start(), oi.Safe())
        assert robot.mode is Mode.SAFE
