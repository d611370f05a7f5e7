"""`python -m create_oi_ros.oi`: see `door`."""

import sys

from .door import run

sys.exit(run())
