#!/usr/bin/env python3
# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Stands in for a node of which there are no wheels: records how it was started, and waits.

`support.ros2` links it into a package as PREFIX/lib/NAME/NAME; the record is PREFIX/NAME.json, a
line for each start: whose child it is, its arguments, and the texts of its parameter files.
"""

import json
import os
from pathlib import Path
import signal
import sys

END = {signal.SIGINT, signal.SIGTERM}
signal.pthread_sigmask(signal.SIG_BLOCK, END)
program, *arguments = sys.argv
files = [Path(path).read_text() for flag, path in zip(arguments, arguments[1:])
         if flag == '--params-file']
folder, name = Path(program).parents[2], Path(program).name
with (folder / f'{name}.json').open('a') as record:
    record.write(json.dumps([os.environ['CREATE_OI_TEST_PROGRAM'], arguments, files]) + '\n')
signal.sigwait(END)
