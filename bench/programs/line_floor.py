# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The least that serves a line: `line_floor.py PATH SIZE PERIOD`.

It writes SIZE zeros to a pseudo terminal at PATH every PERIOD seconds, until it is killed. It
simulates nothing and obeys nothing, so what a served robot takes beyond this is its own work.
"""

import os
import select
import sys
from time import monotonic
import tty

path, size, period = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
master, slave = os.openpty()
tty.setraw(slave)
os.set_blocking(master, False)
os.symlink(os.ttyname(slave), path)
print('ready', flush=True)

frame = bytes(size)
begun = monotonic()
slots = 0
while True:
    slots += 1
    while (wait := begun + slots * period - monotonic()) > 0:
        if select.select([master], [], [], wait)[0]:
            os.read(master, 4096)
    try:
        os.write(master, frame)
    except BlockingIOError:
        pass  # nobody reads, as on a line without a host
