"""
The fault campaign: the real node and a simulated robot as processes, and what happens to them.

`stage` sets the scene and watches what is published, `cases` are the faults, `table` holds what
came of them. `make faults` runs all, `make test` a few, once each.
"""
