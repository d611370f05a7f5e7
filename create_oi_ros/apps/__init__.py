"""The programs, a file or a package each. None imports another; they start each other by name."""
