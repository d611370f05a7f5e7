"""What the Create does with each byte: by the manual, and by guesses where it is silent."""

from .create import Create
from .guesses import Guesses

__all__ = ['Create', 'Guesses']
