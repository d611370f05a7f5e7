"""Pictures of characters for terminals: a canvas with colours, box lines, Braille dots. Pure."""
