# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The real `ros2` commands and `launch`: those in build/ros2, or of an installed ROS.

Without them, a file of tests that imports this is skipped.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import json
import os
from pathlib import Path
import re
import shutil
from typing import Any

import pytest
import yaml

from support.processes import kill_marked
from support.ros import Program, Scene, scene, TIMEOUT
from support.source import ROOT

TOOLS = ROOT / 'build' / 'ros2'
"""Prefix under which `.ci/run` installs them; an installed ROS has them, too."""
MISSING = ('no `ros2` here: pip install into build/ros2, by their tags, ros2/launch 3.4.3, '
           'ros2/launch_ros 0.26.6, ros2/ros2cli 0.32.2 and what CONTRIBUTING.md names')
STAND_INS = 'robot_state_publisher', 'rviz2'
"""Packages of which there are no wheels."""


PROGRAM = shutil.which('ros2', path=f'{TOOLS}/bin{os.pathsep}{os.environ["PATH"]}')
if PROGRAM is None:
    pytest.skip(MISSING, allow_module_level=True)


def add_stand_ins(prefix: Path) -> None:
    """Make packages whose only program records how it was started."""
    for name in STAND_INS:
        marker = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages' / name
        program = prefix / 'lib' / name / name
        for path in (marker, program):
            path.parent.mkdir(parents=True, exist_ok=True)
        marker.touch()
        program.symlink_to(Path(__file__).with_name('stand_in.py'))


class Started:
    """How a stand-in was started."""

    def __init__(self, arguments: list[str], files: list[str]) -> None:
        start = arguments.index('--ros-args')
        self.arguments = arguments[:start]
        self.rules = [value for flag, value in zip(arguments[start:], arguments[start + 1:])
                      if flag == '-r']
        """Its remap rules, such as `__ns:=/robot1`."""
        self.parameters: dict[str, Any] = {}
        for text in files:
            for values in yaml.safe_load(text).values():
                self.parameters |= values['ros__parameters']


class Launch:
    """A `ros2 launch` on a terminal."""

    def __init__(self, program: Program, stage: Scene, stand_ins: Path) -> None:
        self._program, self._stage, self._stand_ins = program, stage, stand_ins

    @property
    def output(self) -> str:
        """All that it and its programs have printed so far."""
        return self._program.output

    def until(self, text: str, count: int = 1) -> None:
        """Wait until it has printed a text so often, for each as long as for one program."""
        self._stage.ros.until(
            lambda: self.output.count(text) >= count or not self._program.running(), text,
            within=count * TIMEOUT)
        assert self.output.count(text) >= count, self.output

    def pid(self, name: str) -> int:
        """Return the newest process of a program, by launch's own words."""
        return int(re.findall(rf'\[{name}-\d+\]: process started with pid \[(\d+)\]',
                              self.output)[-1])

    def started(self, name: str, count: int = 1) -> list[Started]:
        """Wait until it has started a stand-in so often, and return how."""
        record = self._stand_ins / f'{name}.json'

        def found() -> list[Started] | None:
            *whole, _ = record.read_text().split('\n') if record.exists() else ['']
            made = [Started(arguments, files) for mark, arguments, files in map(json.loads, whole)
                    if mark == self._program.mark]
            return made if len(made) >= count else None
        return self._stage.ros.until(found, name)

    def interrupt(self) -> None:
        """Press Ctrl-C, and wait for the end."""
        self._program.type('\x03')
        assert self.ended() == 0, self.output

    def kill(self) -> None:
        """End it, and all that it started, at once."""
        kill_marked(self._program.mark)

    def ended(self) -> int:
        """Wait for its end, and that of all that it started; return its exit code."""
        code = self._program.ended()
        left = self._program.outlived()
        assert not left, f'{left} still run after\n{self.output}'
        return code


class Ros2:
    """A scene with the real tools, in a ROS domain of its own."""

    def __init__(self, stage: Scene, stand_ins: Path) -> None:
        self.stage, self._stand_ins = stage, stand_ins
        self._launches: list[Launch] = []

    def start(self, *words: str, terminal: bool = False) -> Program:
        """Start `ros2` with these words."""
        return self.stage.python(PROGRAM, *words, terminal=terminal)

    def run(self, *words: str, shows: Callable[[str], Any] = bool) -> str:
        """
        Run `ros2` until it ends well and shows what it should; return what it has printed.

        Its daemon needs some time to know the graph.
        """
        ran: list[Program] = []

        def good() -> bool:
            ran.append(self.start(*words))
            return ran[-1].ended() == 0 and bool(shows(ran[-1].output))
        try:
            self.stage.ros.until(good, ' '.join(words))
        except AssertionError as error:
            raise AssertionError(f'{error}; it printed\n{ran[-1].output}') from None
        return ran[-1].output

    def launch(self, *words: str) -> Launch:
        """Start `ros2 launch`, and kill what a test that failed has left on its ports."""
        for earlier in self._launches:
            earlier.kill()
        self._launches.append(
            Launch(self.start('launch', *words, terminal=True), self.stage, self._stand_ins))
        return self._launches[-1]


@contextmanager
def real_tools(folder: Path) -> Iterator[Ros2]:
    """Yield the tools in a folder and ROS domain of their own."""
    with pytest.MonkeyPatch.context() as patch:
        for packages in TOOLS.glob('lib/python3*/site-packages'):  # none if ROS is installed
            for name, path in (('PATH', TOOLS / 'bin'), ('PYTHONPATH', packages),
                               ('AMENT_PREFIX_PATH', TOOLS)):
                patch.setenv(name, str(path), prepend=os.pathsep)
        add_stand_ins(folder / 'stand_ins')
        patch.setenv('AMENT_PREFIX_PATH', str(folder / 'stand_ins'), prepend=os.pathsep)
        patch.setenv('ROS_LOG_DIR', str(folder / 'log'))
        with scene(folder) as stage:
            yield Ros2(stage, folder / 'stand_ins')
