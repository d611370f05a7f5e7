"""The robot's body: wheels, encoders, bumper, sensors and battery, in a world."""

from .body import Body
from .config import BodyConfig
from .encoders import Rounding

__all__ = ['Body', 'BodyConfig', 'Rounding']
