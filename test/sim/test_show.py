# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_sim --show`: the picture in a terminal, and what is written elsewhere."""

from collections.abc import Iterator
from contextlib import contextmanager
import os
import re
import subprocess
import sys
from typing import TextIO

import pytest

from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.sim.server.show import has_cursor
from support.simulator import simulator


@contextmanager
def shown(*arguments: str) -> Iterator[TextIO]:
    """Run `create_sim --show` in a terminal; yield what it writes there."""
    master, slave = os.openpty()
    process = subprocess.Popen(
        [sys.executable, '-c', PROGRAMS['create_sim'], '--show', *arguments],
        stdout=slave, env={**os.environ, 'TERM': 'xterm'})
    os.close(slave)
    try:
        with open(master, encoding='utf-8', newline='') as screen:
            yield screen
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize('world', ['empty', 'room', 'apartment', 'table'])
def test_show_draws_the_room_in_24_lines_of_80(world: str) -> None:
    with shown('--world', world, '--speed', '5') as screen:
        drawn = ''
        while drawn.count('\x1b[H') < 3:
            drawn += screen.readline()
    lines = re.sub(r'\x1b\[[\d;]*[KGm]', '', drawn.split('\x1b[H')[-2]).split('\r\n')
    assert len(lines) == 24
    assert max(map(len, lines)) <= 80
    assert 'OFF' in lines[21]
    assert any(arrow in drawn for arrow in '→↑')
    assert any(corner in drawn for corner in '┌┐└┘') is (world in ('room', 'apartment'))
    assert ('~' in drawn) is (world in ('table', 'apartment'))


def test_show_writes_no_escapes_into_a_pipe_and_fewer_pictures() -> None:
    with simulator('--show', '--world', 'room', '--speed', '5') as sim:
        assert sim.process.stdout is not None
        drawn = sim.said
        while drawn.count(' OFF ') < 3:
            drawn += sim.process.stdout.readline()
        sim.stop()
    assert '\x1b' not in drawn
    times = [float(line.split()[0]) for line in drawn.splitlines() if ' OFF ' in line]
    assert times == pytest.approx([1.005, 2.01, 3.015], abs=0.06)


def test_it_ends_quietly_when_the_reader_of_its_pictures_has_gone() -> None:
    with simulator('--show', '--speed', '20') as sim:
        assert sim.process.stdout is not None
        assert sim.process.stderr is not None
        sim.process.stdout.close()
        assert (sim.process.wait(20), sim.process.stderr.read()) == (141, '')


@pytest.mark.parametrize('term', ['dumb', None])
def test_a_terminal_without_a_cursor_gets_no_escapes(
        monkeypatch: pytest.MonkeyPatch, term: str | None) -> None:
    if term is None:
        monkeypatch.delenv('TERM', raising=False)
    else:
        monkeypatch.setenv('TERM', term)
    master, slave = os.openpty()
    with open(master, 'rb'), open(slave, 'w') as screen:
        assert screen.isatty() and not has_cursor(screen)
