"""
One page that tells what a robot did, made from a bag: the command `create_report`.

`bag` opens bags, `reading` streams one into a `Recording`, `story` puts that into words,
`drawing` into a picture, `page` both into a file.
"""
