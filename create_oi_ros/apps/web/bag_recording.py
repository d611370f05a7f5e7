# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Records a bag when a page asks for it, and makes its report; other programs do the work."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from itertools import pairwise
from pathlib import Path
import subprocess
import time

from ...ros.node_arguments import names_only
from ...ros.process import start
from .access import Refused
from .live_robot import LiveRobot


class BagRecording:
    """One recording at a time; the pages are shown how it is."""

    def __init__(self, robot: LiveRobot, ros_arguments: Sequence[str]) -> None:
        """Give the recorder the names and the enclave of the ROS arguments of this program."""
        self._robot = robot
        self._ros = names_only(ros_arguments) + [
            part for flag, value in pairwise(ros_arguments)
            if flag in ('-e', '--enclave') for part in (flag, value)]
        self._process: subprocess.Popen[bytes] | None = None
        self._folder = Path()
        self._target: Path | None = None
        """The report that is being made."""
        self.report: Path | None = None
        """The report of the last bag."""
        self._show('off')

    def _show(self, state: str) -> None:
        now = time.monotonic()
        self._robot.parts.put('recording', {
            'state': state, 'folder': str(self._folder), 'at': round(now, 1)})
        if state != 'off':
            self._robot.happened('error' if state == 'failed' else '',
                                 f'recording {state}: {self._folder}', now)

    def switch(self, *, on: bool) -> None:
        """Begin or end a recording, in a new folder of the working directory; Refused: why not."""
        if on:
            if self._process is not None:
                raise Refused('a recording is under way, or its report is being made')
            self._folder = Path(f'record-{datetime.now():%Y%m%d-%H%M%S}').absolute()
            self._process = start('create_record', '-o', str(self._folder), '--ros-args',
                                  *self._ros)
            self.report = None
            self._show('on')
        elif self._process is not None and self._target is None:
            self._process.terminate()
            self._show('ending')

    def look(self) -> None:
        """Go on when a program has ended: after the bag comes its report."""
        if self._process is None or (code := self._process.poll()) is None:
            return
        made, self._target, self._process = self._target, None, None
        if code != 0:
            self._show('failed')
        elif made is not None:
            self.report = made
            self._show('reported')
        else:
            self._target = self._folder.with_suffix('.html')
            self._process = start('create_report', str(self._folder), '-o', str(self._target))
