"""The programs, a file or a package each. They know each other by name only."""
