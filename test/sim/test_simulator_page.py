# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages of the simulator name every word, fault and guess there is."""

from dataclasses import fields
from enum import Enum
from pathlib import Path

import pytest

from create_oi_ros.sim.firmware.guesses import DEFAULT_GUESSES, Guesses
from create_oi_ros.sim.server.control import WORDS
from create_oi_ros.sim.server.faults import FaultKind
from create_oi_ros.sim.world import parse, WorldError
from create_oi_ros.sim.world.world import KEYWORDS

PAGES = Path(__file__).parents[2] / 'docs'
DOCS = (PAGES / 'simulator.md').read_text('utf-8')
GUESSES = (PAGES / 'simulator_guesses.md').read_text('utf-8')


def test_the_room_on_its_page_is_one() -> None:
    text = (PAGES / 'own_room.md').read_text('utf-8')
    room = parse(text.split('```')[1], 'my.world')
    assert room.home_bases and room.cliffs and room.patches
    with pytest.raises(WorldError, match='my.world, line 3: 3 numbers after .box.; allowed: "box'):
        parse('start 0 0 0\n\nbox 1 1 1', 'my.world')
    assert all(f'`{word} ' in text for word in KEYWORDS)


@pytest.mark.parametrize('form', [
    *(f'{name} {word.form}'.strip().replace('|', r'\|') for name, word in WORDS.items()),
    *(kind.value for kind in FaultKind)])
def test_every_word_of_the_control_socket_and_every_kind_of_fault_is_there(form: str) -> None:
    assert f'`{form}`' in DOCS


@pytest.mark.parametrize('name', [field.name for field in fields(Guesses)])
def test_every_guess_is_there_with_its_default(name: str) -> None:
    value = getattr(DEFAULT_GUESSES, name)
    shown = (str(value).lower() if isinstance(value, bool) else
             value.value if isinstance(value, Enum) else f'{value:g}')
    assert f'`--guess {name}={shown}`' in GUESSES
