# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Draw docs/drive.gif: `python bench/draw_drive.py [PATH]`, a simulated robot along a wall."""

from collections.abc import Iterator
from math import degrees
from pathlib import Path
from runpy import run_path
import sys
from typing import NamedTuple

from PIL import Image, ImageDraw, ImageFont

from create_oi_ros.driver import Driver, Moved, Settings
from create_oi_ros.robot import BODY_RADIUS
from create_oi_ros.sim.body import Body
from create_oi_ros.sim.firmware import Create
from create_oi_ros.sim.firmware.guesses import Guesses
from create_oi_ros.sim.world import Pose, shipped
from create_oi_ros.sim.world.geometry import Disc

ROOT = Path(__file__).parents[1]
EXAMPLE = run_path(str(ROOT / 'examples' / 'follow_wall.py'))
STEP, SECONDS = 0.005, 70.0
FASTER, FRAMES_A_SECOND = 4, 10
SCALE, MARGIN, CAPTION = 110, 12, 26
"""Pixels of a metre, around the room, and for the line of text."""
SMOOTH = 3
"""The picture is drawn so many times larger, and reduced."""
COLORS = 32
PAPER, WALL, CARPET = '#fbfaf7', '#30343f', '#e9e2d0'
BODY, TOUCHED, TRACK, BELIEVED, BASE = '#8d99ae', '#d1495b', '#30343f', '#00798c', '#e09f3e'


class Moment(NamedTuple):
    """What one picture shows."""

    pose: Pose
    believed: Pose
    touched: tuple[bool, bool]
    text: str


def drive(world, seconds: float) -> Iterator[Moment]:
    """Let the example drive the simulated robot through the driver, in memory."""
    body = Body(world)
    robot, driver = Create(body, guesses=Guesses(boot_seconds=0)), Driver(Settings())
    steering, moved, start = EXAMPLE['Steering'](), None, world.start
    now, commanded = 1.0, 1.0
    driver.connected(now)
    for step in range(round(seconds / STEP)):
        now += STEP
        robot.poll(now)
        driver.receive(robot.data_to_send(), now)
        driver.poll(now)
        while (event := driver.next_event()) is not None:
            moved = event if isinstance(event, Moved) else moved
        seen = body.sense()
        if moved is not None and now - commanded >= EXAMPLE['PERIOD']:
            driver.drive(*steering.next_move(seen.bump_left or seen.bump_right, seen.wall_signal),
                         now)
            commanded = now
        robot.receive(driver.data_to_send(), now)
        if moved is not None and step % round(FASTER / FRAMES_A_SECOND / STEP) == 0:
            estimate = moved.estimate
            x, y = start.ahead(estimate.x, estimate.y)
            yield Moment(
                body.truth().pose, Pose(x, y, start.yaw + estimate.yaw),
                (bool(seen.bump_left), bool(seen.bump_right)),
                f'{robot.mode.name}    x {estimate.x:+z.2f}  y {estimate.y:+z.2f} m   '
                f'{degrees(estimate.yaw):+z.0f} deg   {body.truth().speed:+z.2f} m/s')


class Canvas:
    """Draws a world in metres; the room of 4 m by 3 m fills it."""

    def __init__(self, world, width: float, height: float) -> None:
        self._width, self._height = width, height
        self.size = (round(width * SCALE) + 2 * MARGIN, round(height * SCALE) + 2 * MARGIN)
        self._empty = Image.new('RGB', tuple(SMOOTH * each for each in self.size), PAPER)
        draw = ImageDraw.Draw(self._empty)
        for _, region in world.patches:
            draw.polygon(self.points(region.points), fill=CARPET)
        for obstacle in world.obstacles:
            if isinstance(obstacle, Disc):
                self.disc(draw, (obstacle.x, obstacle.y), obstacle.radius, fill=WALL)
            else:
                draw.line(self.points(obstacle.ends), WALL, 4 * SMOOTH)
        for base in world.home_bases:
            draw.line(self.points(base.plate.ends), BASE, 9 * SMOOTH)

    def point(self, place) -> tuple[float, float]:
        """Return the pixel of a place."""
        x, y = place[:2]
        return (SMOOTH * (MARGIN + SCALE * (x + self._width / 2)),
                SMOOTH * (MARGIN + SCALE * (self._height / 2 - y)))

    def points(self, places) -> list[tuple[float, float]]:
        """Return the pixels of places."""
        return [self.point(place) for place in places]

    def disc(self, draw, center, radius: float, **ink) -> None:
        """Draw a circle."""
        (x, y), r = self.point(center), SMOOTH * SCALE * radius
        draw.ellipse((x - r, y - r, x + r, y + r), **ink)

    def picture(self, moment: Moment, tracks: list[list[Pose]], font) -> Image.Image:
        """Draw a moment, and where robot and odometry were before."""
        large = self._empty.copy()
        draw = ImageDraw.Draw(large)
        for track, color, width in zip(tracks, (BELIEVED, TRACK), (2.5, 1)):
            if len(track) > 1:
                draw.line(self.points(track), color, round(width * SMOOTH), joint='curve')
        pose = moment.pose
        self.disc(draw, pose, BODY_RADIUS, fill=BODY, outline=WALL, width=SMOOTH)
        draw.line((self.point(pose), self.point(pose.ahead(BODY_RADIUS))), WALL, 2 * SMOOTH)
        (x, y), r = self.point(pose), SMOOTH * SCALE * BODY_RADIUS
        ahead = -degrees(pose.yaw)
        for touched, begin in zip(moment.touched, (ahead - 90, ahead)):
            if touched:
                draw.arc((x - r, y - r, x + r, y + r), begin, begin + 90, TOUCHED, 5 * SMOOTH)
        whole = Image.new('RGB', (self.size[0], self.size[1] + CAPTION), PAPER)
        whole.paste(large.resize(self.size, Image.Resampling.LANCZOS))
        ImageDraw.Draw(whole).text((MARGIN, self.size[1] - 2), moment.text, WALL, font)
        return whole


def palette(picture: Image.Image) -> Image.Image:
    """Return a picture with the colors of this one, and with those that are seen only at times."""
    sample = picture.copy()
    for place, color in enumerate((BASE, TOUCHED, BODY, BELIEVED)):
        sample.paste(color, (60 * place, 60, 60 * place + 60, 120))
    return sample.quantize(COLORS, kmeans=2)


def main() -> None:
    """Draw the drive; the track of the odometry lies under the true one."""
    world = shipped('room')
    canvas, font = Canvas(world, 4.0, 3.0), ImageFont.load_default(14)
    pictures, tracks = [], [[], []]
    for moment in drive(world, SECONDS):
        tracks[0].append(moment.believed)
        tracks[1].append(moment.pose)
        pictures.append(canvas.picture(moment, tracks, font))
    colors = palette(pictures[-1])
    frames = [each.quantize(palette=colors, dither=Image.Dither.NONE) for each in pictures]
    path = Path(sys.argv[1] if len(sys.argv) > 1 else 'docs/drive.gif')
    frames[0].save(path, save_all=True, append_images=frames[1:], optimize=True, loop=0,
                   duration=round(1000 / FRAMES_A_SECOND))


if __name__ == '__main__':
    main()
