# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Draw docs/lidar.png: `python bench/draw_lidar.py [PATH]`, what a lap's scans draw."""

import sys

import numpy as np
from PIL import Image, ImageDraw

from create_oi_ros.robot import BODY_RADIUS
from create_oi_ros.sim.world import shipped
from lap import lap

SCALE, MARGIN = 100, 12
"""Pixels of a metre, and around the apartment of 8 m by 6 m."""
SMOOTH = 2
"""The picture is drawn so many times larger, and reduced."""
PAPER, MET, TRACK, ROBOT = '#fbfaf7', '#d1495b', '#00798c', '#30343f'


def main() -> None:
    """Draw the ends of all beams, the track of the odometry, and the robot at its end."""
    scans = list(lap(shipped('apartment')))
    size = SMOOTH * (8 * SCALE + 2 * MARGIN), SMOOTH * (6 * SCALE + 2 * MARGIN)
    picture = Image.new('RGB', size, PAPER)
    draw = ImageDraw.Draw(picture)

    def pixel(x: float, y: float) -> tuple[float, float]:
        return SMOOTH * (MARGIN + SCALE * x), SMOOTH * (MARGIN + SCALE * (6 - y))
    for scan in scans:
        met = np.isfinite(scan.x)
        draw.point([pixel(*each) for each in zip(scan.x[met], scan.y[met])], MET)
    draw.line([pixel(*scan.robot[:2]) for scan in scans], TRACK, 2 * SMOOTH)
    (x, y), radius = pixel(*scans[-1].robot[:2]), SMOOTH * SCALE * BODY_RADIUS
    draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=ROBOT, width=2 * SMOOTH)
    picture.resize((size[0] // SMOOTH, size[1] // SMOOTH), Image.Resampling.LANCZOS).quantize(
        32).save(sys.argv[1] if len(sys.argv) > 1 else 'docs/lidar.png', optimize=True)


if __name__ == '__main__':
    main()
