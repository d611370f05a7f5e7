# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_report`: shows what a robot did, from a bag, on a page to replay and zoom.

`bag_reader` reads a bag into a `Recording`, with `recovery` for files that were never closed,
and `summary` describes it in words. `page` writes it from the files in `live/` and the data of
`page_data`, thinned by `thinning`.
"""
