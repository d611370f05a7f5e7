# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Runs the commands of the documentation pages.

The blocks of `docs/tutorial.md` are run in order, all in the ROS domain of the first terminal.

A block marked `terminal N` keeps running; with `: TEXT` the next one waits until TEXT was printed.
It ends before a block marked `after Ctrl-C in terminal N`. A block marked
`until: TEXT; then Ctrl-C` is ended when TEXT was printed, with `until twice` when it was printed
twice. The lines of a `text` block must appear in the output; numbers may differ. A block that is
not run is marked `not run:` and one of the REASONS.
"""

from collections.abc import Callable
import os
from pathlib import Path
import re
import shlex
import signal
import subprocess
from typing import Any

import pytest

from create_oi_ros.apps.report.recording import read
from support.ros import Program, Scene
from support.source import Block, blocks, ROOT

PAGE = ROOT / 'docs' / 'tutorial.md'
BLOCKS = blocks(PAGE)
REASONS = {'ros2': {'ros2'}, 'robot': {'create_run', 'create_node', 'python'}}
"""Reasons for not running a block, and the programs that such a block may name."""
JOIN = re.compile(r'export ROS_DOMAIN_ID=\d+')
JOINED = re.compile(r'export ROS_DOMAIN_ID=(\d+)$')
"""How further terminals join, and the line of the first one that says so."""
VARYING = re.compile(r'\b(left|right)$|\b(True|False)\b|[+-]?\d+(\.\d+)?(e-?\d+)?')
"""Parts of a line that may differ from run to run: numbers, booleans, left or right."""


class Terminal:
    """A shell that runs a block; Ctrl-C reaches every process in it."""

    def __init__(self, text: str, folder: Path, environment: dict[str, str]) -> None:
        if 'ROS_DOMAIN_ID' in environment:
            # Where the reader types the number that the first terminal shows, so does the test.
            text = JOIN.sub(f'export ROS_DOMAIN_ID={environment["ROS_DOMAIN_ID"]}', text)
        self.process = subprocess.Popen(
            ['bash', '-ec', f'source env.sh\n{text}'], cwd=folder, env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
        self.printed: list[str] = []

    def until(self, happened: Callable[[str], Any], what: str) -> Any:
        """Wait for a line for which something is true; return that."""
        for line in self.process.stdout:
            self.printed.append(line)
            if found := happened(line):
                return found
        raise AssertionError(f'{what} was not printed: {"".join(self.printed)}')

    def shows(self, expected: str) -> None:
        """Wait for a line like this one, unless it was printed before."""
        if shape(expected) not in map(shape, self.printed):
            self.until(lambda line: shape(line) == shape(expected), expected)

    def prints(self, text: str) -> None:
        """Wait for a line that contains a text."""
        self.until(lambda line: text in line, text)

    def interrupt(self) -> None:
        """Press Ctrl-C."""
        os.killpg(self.process.pid, signal.SIGINT)

    def ended(self) -> int:
        """Wait for the end of the shell; return its exit code."""
        self.printed += self.process.stdout.readlines()
        return self.process.wait()


def shape(line: str) -> str:
    """Return a line with everything replaced that may differ."""
    return ' '.join(VARYING.sub('#', line).split())


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the files of the clone that the page uses."""
    (tmp_path / 'env.sh').write_text(f'source {shlex.quote(str(ROOT))}/env.sh\n')
    (tmp_path / 'examples').symlink_to(ROOT / 'examples')
    return tmp_path


@pytest.fixture
def environment():
    """Return an environment without a ROS domain: the first terminal prints that of its robot."""
    made = {**os.environ, 'PYTHONUNBUFFERED': '1'}
    made.pop('ROS_DOMAIN_ID', None)
    return made


def run(block: Block, folder: Path, environment: dict[str, str]) -> Terminal:
    """Run a block to its end."""
    terminal = Terminal(block.text, folder, environment)
    until = re.fullmatch(r'until( twice)?: (.*); then Ctrl-C', block.mark)
    if until:
        for _ in range(2 if until[1] else 1):
            terminal.prints(until[2])
        terminal.interrupt()
    code, printed = terminal.ended(), ''.join(terminal.printed)
    assert code == 0, printed
    assert 'Traceback' not in printed, printed
    return terminal


@pytest.mark.nightly
@pytest.mark.timeout(300)
def test_the_tutorial_works(folder, environment):
    pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')
    running: dict[str, Terminal] = {}
    latest: Terminal | None = None
    try:
        for block in BLOCKS:
            lasting = re.fullmatch(r'terminal (\d)(?:: (.*))?', block.mark)
            ending = re.fullmatch(r'after Ctrl-C in terminal (\d)', block.mark)
            match block.language, block.mark:
                case 'bash', 'terminal 1':
                    latest = running['1'] = Terminal(block.text, folder, environment)
                    environment['ROS_DOMAIN_ID'] = latest.until(JOINED.search, 'a domain')[1]
                case 'bash', _ if lasting:
                    latest = running[lasting[1]] = Terminal(block.text, folder, environment)
                    if lasting[2]:
                        latest.prints(lasting[2])
                case 'bash', _:
                    if ending:
                        terminal = running.pop(ending[1])
                        terminal.interrupt()
                        assert terminal.ended() == 0
                    latest = run(block, folder, environment)
                case 'python', mark:
                    (folder / mark.removeprefix('file: ')).write_text(block.text)
                case 'text', _:
                    for line in block.text.splitlines():
                        latest.shows(line)
    finally:
        for terminal in running.values():
            terminal.interrupt()
            terminal.ended()
    text = (folder / 'my' / 'walk.html').read_text()
    assert 'Bump' in text and 'id="data">e' in text, 'an event, and packed curves'
    recording = read(folder / 'my' / 'walk')
    assert recording.events.spans['bumper'].all and len(recording.odom) > 20


@pytest.mark.nightly
@pytest.mark.timeout(400)
def test_make_demo_drives_its_tour_and_makes_a_report(tmp_path):
    pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')
    done = subprocess.run(
        ['bash', '-c', f'source {shlex.quote(str(ROOT))}/env.sh && exec "$0"',
         str(ROOT / 'tools' / 'demo.sh')],
        cwd=tmp_path, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=350)
    assert done.returncode == 0, done.stdout
    [folder] = tmp_path.iterdir()
    assert done.stdout.endswith(f'{folder.name}/report.html\n') and 'Traceback' not in done.stdout
    seen = read(folder / 'bag').events.spans
    assert [len(seen[kind].all) for kind in ('bumper', 'cliff', 'song')] == [2, 1, 2]
    assert 'Bump' in (folder / 'report.html').read_text()


# The commands of our programs in other pages, in their order, in a folder.


OURS = re.compile(r'create_(node|record|report|sim|web)( |$)'
                  r'|python -m create_oi_ros\.oi (?!document)')
PATH = re.compile(r'/dev/ttyUSB0|/tmp/(\w+)')
RECORDED = 150_000
"""Bytes of a bag that holds a second of the driver's topics."""


def ours(page: str) -> list[list[str]]:
    """Return the commands of our programs in the fenced blocks of a page, as words."""
    lines = [line for block in blocks(ROOT / page) for line in block.text.splitlines()]
    return [shlex.split(line, comments=True) for line in lines if OURS.match(line)]


class Page:
    """
    Runs a page's commands, with a robot and a driver that writes a capture.

    Ports are replaced by that of a simulated robot. What runs until Ctrl-C is ended when it works;
    a simulator runs until another program needs its port, or the page is done.
    """

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
                self._to_its_end(self._stage.python(*arguments))
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
        ('docs/recording.md', 5), ('docs/simulator.md', 8),
        ('docs/web.md', 3)))])
def test_the_commands_of_a_page_work(page, count, stage, tmp_path, monkeypatch):
    pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')
    monkeypatch.chdir(tmp_path)
    found = ours(page)
    assert len(found) == count
    running = Page(stage)
    for words in found:
        running.run(words)
    running.end()
