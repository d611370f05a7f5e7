"""
A robot that shows itself: the command `create_demo`.

`pilot` drives and waits for what the robot reports, `tour` is what it shows, `command` starts,
records and ends all of it.
"""
