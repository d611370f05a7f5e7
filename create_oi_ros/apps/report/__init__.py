"""
`create_report`: shows on one page what a robot did, from a bag.

`bag_reader` reads a bag into a `Recording`, with `recovery` for files that were never closed.
`summary` describes it in words, `drawing` and `track_drawing` as a picture in `colors`, `page`
writes both to a file.
"""
