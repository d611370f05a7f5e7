# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The colours of the report.

They are those of Okabe and Ito, "Color universal design", which people tell apart who see red and
green alike; and grey. Events also differ by the form of their mark.
"""

BLUE, ORANGE, GREEN, VERMILION = '#0072B2', '#E69F00', '#009E73', '#D55E00'
SKY, PURPLE, GREY = '#56B4E9', '#CC79A7', '#555555'
MEASURED, COMMANDED, FAULTS, GAP = BLUE, ORANGE, VERMILION, '#bbbbbb'
MODES = {'Off': GREY, 'Passive': ORANGE, 'Safe': SKY, 'Full': PURPLE, 'no robot': '#dddddd'}
COLORS = {'bumper': VERMILION, 'cliff': 'black', 'wheel drop': BLUE, 'mode': PURPLE,
          'song': GREEN, 'buttons': GREY, 'charging': SKY, 'gap': '#888888',
          'overcurrent': ORANGE}
MARKS = {'bumper': 'X', 'cliff': 'v', 'wheel drop': '^', 'mode': 'D', 'song': 'o',
         'buttons': 's', 'charging': 'P', 'gap': 'p', 'overcurrent': '*'}
