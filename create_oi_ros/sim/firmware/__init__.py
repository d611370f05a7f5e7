"""What the Create does with each byte, by the manual, and what had to be guessed."""

from .create import Create
from .guesses import Guesses

__all__ = ['Create', 'Guesses']
