# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The steps of the tour through the world `apartment`; the robot starts at (0, 0)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import dist, pi, tau
from typing import NamedTuple

from create_oi_msgs.msg import Mode

from .pilot import Pilot

WORLD = 'apartment'
GREEN, ORANGE, RED = 0, 96, 255
"""Colours of the power LED."""
HELLO, GOODBYE = 'C5:0.2 E5:0.2 G5:0.2 C6:0.4', 'G5:0.25 E5:0.25 C5:0.5'
"""Notes with their seconds."""
SIDE, RADII = 0.6, (0.15, 0.25, 0.35)
"""Side of the square, and radii of the circles, metres."""
WALL_AHEAD = (-0.1, -1.5)
"""A point in front of a wall of the living room; x is the robot's first heading."""
DOORS = ((0.4, -1.05), (2.85, -1.05), (2.85, -3.25))
"""The way to the hall, through two doors."""
EDGE_SPEED = 0.05
"""m/s towards the stairs: from faster the robot comes to rest with its caster over the edge, and
cannot go back to Safe."""
BACK_SPEED = 0.1
"""m/s away from them."""
EDGE_TIMEOUT = 40.0
"""Seconds in which it reaches them."""


class TourStep(NamedTuple):
    """A step of the tour: its title and what it does."""

    title: str
    do: Callable[[Pilot], None]


def hello(pilot: Pilot) -> None:
    """Wait for the robot, and play a tune."""
    pilot.until(lambda: pilot.odom is not None and pilot.mode == Mode.SAFE,
                'the robot answers and is in Safe', 30.0)
    pilot.call('set_leds', play=True, power_color=GREEN, power_intensity=255)
    pilot.do('audio_note_sequence', notes=HELLO)


def square(pilot: Pilot) -> None:
    """Drive a square to the right, and turn back to the first heading."""
    for x, y in ((SIDE, 0.0), (SIDE, -SIDE), (0.0, -SIDE), (0.0, 0.0)):
        pilot.go_to(x, y)
    pilot.turn_to(0.0)


def circles(pilot: Pilot) -> None:
    """Drive circles to the right, each larger than the one before."""
    pilot.call('set_leds', advance=True, power_color=ORANGE, power_intensity=255)
    for radius in RADII:
        pilot.do('drive_arc', angle=-tau, radius=radius, translate_direction=1)


def bump_and_turn(pilot: Pilot) -> None:
    """Bump into two walls, backing off each time."""
    pilot.go_to(*WALL_AHEAD)
    for heading in (-pi / 2, 0.0):
        pilot.turn_to(heading)
        pilot.command(0.2, 0.0)
        pilot.until(lambda: pilot.bumped, 'a bump into a wall', 20.0)
        pilot.do('drive_distance', distance=-0.2)


def to_the_hall(pilot: Pilot) -> None:
    """Drive through two doors."""
    pilot.call('set_leds', play=True, advance=True, power_color=GREEN,
               power_intensity=128)
    for x, y in DOORS:
        pilot.go_to(x, y)
    pilot.turn_to(0.0)


def cliff(pilot: Pilot) -> None:
    """Drive to the stairs, where the robot stops by itself in Passive; come back."""
    pilot.command(EDGE_SPEED, 0.0)
    pilot.until(lambda: pilot.mode == Mode.PASSIVE, 'a cliff drops the robot to Passive',
                EDGE_TIMEOUT)
    pilot.release()
    pilot.until(lambda: pilot.standing, 'the robot stands at the edge')
    pilot.until(lambda: any('PASSIVE instead of SAFE' in each for each in pilot.warnings),
                'the diagnostics warn of Passive')
    # The robot rolls on a little: where a wheel hangs over the edge, it refuses Safe, and the
    # driver refuses goals, but not velocities.
    pilot.call('set_mode', mode=Mode.FULL)
    edge = pilot.place
    pilot.command(-BACK_SPEED, 0.0)
    pilot.until(lambda: dist(edge, pilot.place) > 0.4, 'the robot backs off', EDGE_TIMEOUT)
    pilot.stop()
    pilot.release()
    pilot.call('set_mode', mode=Mode.SAFE)
    pilot.until(lambda: pilot.mode == Mode.SAFE, 'the robot is in Safe')


def goodbye(pilot: Pilot) -> None:
    """Turn round, play another tune, and release the wheels."""
    pilot.turn_to(pi)
    pilot.call('set_leds', power_color=RED, power_intensity=60)
    pilot.do('audio_note_sequence', notes=GOODBYE)
    pilot.release()


TOUR: Sequence[TourStep] = (
    TourStep('LEDs and a tune', hello), TourStep('a square', square),
    TourStep('three circles', circles),
    TourStep('bump and turn, twice', bump_and_turn),
    TourStep('through two doors to the hall', to_the_hall),
    TourStep('the stairs: a cliff, Passive, back off in Full, Safe', cliff),
    TourStep('another tune', goodbye))
SHORT: Sequence[TourStep] = (
    TourStep('LEDs and a tune', hello),
    TourStep('a turn', lambda pilot: pilot.turn_to(pi / 2)), TourStep('another tune', goodbye))
