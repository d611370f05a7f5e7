"""
`create_run`: a robot and its node in one terminal, with a status line.

`create_run` starts and ends the processes, `status` makes and shows the line.
"""
