# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Tools that show the Open Interface to people: text form, transcripts, tables, captures."""
