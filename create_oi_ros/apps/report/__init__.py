# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_report`: shows what a robot did, from a bag, on a page to replay and zoom.

`bag_files` reads messages from files in any state, `recording` makes a `Recording` of them,
`summary` describes it in words, `create_report` writes it with the scripts in `live/`.
"""
