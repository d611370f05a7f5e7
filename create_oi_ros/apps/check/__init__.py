"""`create_check`: five guided minutes with a robot that show how it drives and counts."""
