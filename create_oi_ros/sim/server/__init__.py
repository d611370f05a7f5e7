"""
A simulated Create that other programs open like a serial port.

`serve` runs one robot on one line in real time, `control_port` lets others set its world, and
`command` is the executable `create_sim`.
"""

from .create_sim import main
from .serve import Server

__all__ = ['main', 'Server']
