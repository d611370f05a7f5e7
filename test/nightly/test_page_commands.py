# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Runs the commands of our programs in the documentation pages, in their order, in a folder.

Ports are replaced by that of a simulated robot. What runs until Ctrl-C is ended when it works; a
simulator runs until another program needs its port, or the page is done.
"""

from collections.abc import Callable
from pathlib import Path
import re
import shlex
import signal

import pytest

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')

from support.pages import blocks, ROOT
from support.ros import Program, Scene

OURS = re.compile(r'create_(node|record|report|sim|web)( |$)'
                  r'|python -m create_oi_ros\.oi (?!document)')
PATH = re.compile(r'/dev/ttyUSB0|/tmp/(\w+)')
RECORDED = 150_000
"""Bytes of a bag that holds a second of the driver's topics."""


def commands(page: str) -> list[list[str]]:
    """Return the commands of our programs in the fenced blocks of a page, as words."""
    lines = [line for block in blocks(ROOT / page) for line in block.text.splitlines()]
    return [shlex.split(line, comments=True) for line in lines if OURS.match(line)]


class Page:
    """Runs a page's commands, with a robot and a driver that writes a capture."""

    def __init__(self, stage: Scene) -> None:
        self._stage = stage
        self._driver: Program | None = stage.node(stage.robot('robot').link,
                                                  capture='walk.capture')
        self._simulator: Program | None = None
        stage.ros.until(lambda: 'robot answers' in self._driver.output, 'the driver works')

    def run(self, words: list[str]) -> None:
        """Run a command to its end, or until it works."""
        folder = self._stage.folder
        program, *arguments = (
            PATH.sub(lambda found: f'{folder}/{found[1] or "create"}', word) for word in words)
        match program, arguments:
            case 'python', _:
                self._end_driver()
                self._to_its_end(self._stage._start(*arguments))
            case 'create_sim', _ if {'--export', '--say'} & {*arguments}:
                self._to_its_end(self._stage.program(program, *arguments))
            case 'create_sim', _:
                self.end()
                self._simulator = self._stage.program(program, *arguments)
                self._works(self._simulator, lambda: bool(self._simulator.output))
            case 'create_node', _:
                self._end_driver()
                if self._simulator is None:
                    self._stage.robot()
                self._until_ctrl_c(program, arguments, 'robot answers')
            case 'create_record', _:
                self._until_ctrl_c(program, arguments, 'until Ctrl-C', recorded)
            case 'create_web', _:
                self._until_ctrl_c(program, arguments, 'open http://')
            case _:
                self._to_its_end(self._stage.program(program, *arguments))

    def end(self) -> None:
        """End what still runs."""
        self._end_driver()
        if self._simulator is not None and self._simulator.running():
            self._simulator.send(signal.SIGINT)
            self._to_its_end(self._simulator)
        self._simulator = None

    def _end_driver(self) -> None:
        if self._driver is not None:
            self._driver.send(signal.SIGINT)
            self._to_its_end(self._driver)
        self._driver = None

    def _to_its_end(self, started: Program) -> None:
        assert started.ended() == 0, started.output

    def _works(self, started: Program, happened: Callable[[], bool]) -> None:
        self._stage.ros.until(lambda: happened() or not started.running(), started.output)
        assert happened(), started.output

    def _until_ctrl_c(
        self, program: str, arguments: list[str], text: str,
        more: Callable[[], bool] = lambda: True,
    ) -> None:
        started = self._stage.program(program, *arguments)
        self._works(started, lambda: text in started.output and more())
        started.send(signal.SIGINT)
        self._to_its_end(started)


def recorded() -> bool:
    """Return whether a bag in this folder holds messages."""
    return any(file.stat().st_size > RECORDED for file in Path().glob('*/*.mcap'))


@pytest.mark.parametrize(('page', 'count'), [
    ('README.md', 2), *(pytest.param(page, count, marks=pytest.mark.nightly) for page, count in (
        ('docs/recording.md', 5), ('docs/simulator.md', 9),
        ('docs/web.md', 3)))])
def test_the_commands_of_a_page_work(page, count, stage, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = commands(page)
    assert len(found) == count
    running = Page(stage)
    for words in found:
        running.run(words)
    running.end()
