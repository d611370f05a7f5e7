"""The robot's body: wheels, encoders, bumper, sensors and battery, in a world."""

from ...robot import Rounding
from .body import Body
from .config import BodyConfig

__all__ = ['Body', 'BodyConfig', 'Rounding']
