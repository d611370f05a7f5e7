"""
`create_view`: a robot in a terminal, from its topics alone.

What is seen is a pure picture of a `state`: `picture`, of `chart` and `panels` on a `canvas`. What
a key means is a table, `keys`; how long it drives is `teleop`. None of these knows a clock, a
terminal or the ROS graph. `terminal` and `graph` are the two ends, `command` joins them.
"""
