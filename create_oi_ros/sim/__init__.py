"""
A Create without a Create: the robot's side of the Open Interface.

`world` is the room, `body` the robot's mechanics and battery in it, `firmware` what the robot
does with each byte, `server` the pty or TCP port that others talk to.  All but `server` are
pure: time comes in as an argument, chance from a seed, and nothing is read or written.
"""
