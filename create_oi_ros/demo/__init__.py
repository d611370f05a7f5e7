"""
A robot that shows itself: the command `create_demo`.

`recorder` writes a bag, `pilot` drives and waits for what the robot reports, `tour` is what it
shows, `command` starts and ends all of it.
"""
