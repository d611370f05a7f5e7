"""
A bag without an installed `ros2 bag`: the command `create_record`.

`recorder` writes what the driver publishes and what it is commanded, `command` starts and ends it.
"""
