# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`python -m create_oi_ros.oi`: explains and encodes bytes of the Open Interface."""

import sys

from .tools.command_line import run

if __name__ == '__main__':
    sys.exit(run())
