# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The simulated Create survives any bytes."""

from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

from create_oi_ros import oi
from create_oi_ros.oi import Mode
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import shipped
from support.robot import Robot

AT_ONCE = Guesses(opcode_7_resets=False, boot_seconds=0.0)
OPCODES = st.sampled_from([kind.opcode for kind in oi.COMMANDS])
BYTES = st.lists(st.integers(0, 255) | OPCODES, max_size=60).map(bytes)


@given(st.lists(st.tuples(BYTES, st.floats(0, 0.5), st.sampled_from([None, 300, 57600, 115200])),
                max_size=8),
       st.sampled_from(list(Mode)), st.booleans())
@settings(max_examples=300)
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
