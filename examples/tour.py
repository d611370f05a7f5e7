# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Drive a tour of the world `apartment`: tunes, a square, circles, two walls, two doors, the stairs.

    create_run --world apartment
    python examples/tour.py
"""
import argparse
from math import pi, tau

from create_oi_msgs.msg import Mode
from geometry_msgs.msg import Point, Pose, PoseStamped
from rclpy.utilities import remove_ros_args

from create_oi_ros.ros.goal_client import GoalClient, GoalFailed
from create_oi_ros.ros.waiting import wait_for_robot

WALL_AHEAD = -0.1, -1.5
DOORS = (0.4, -1.05), (2.85, -1.05), (2.85, -3.25)
"""Places in the frame of the odometry, which begins where the robot stands, m."""
EDGE_SPEED = 0.05
"""m/s towards the stairs: from faster the robot rolls on until a wheel hangs over the edge."""


def go_to(robot: GoalClient, x: float, y: float) -> None:
    """Turn towards a place and drive there."""
    place = Pose(position=Point(x=x, y=y))
    robot.do('navigate_to_position', goal_pose=PoseStamped(pose=place))


def drive_until_stopped(robot: GoalClient, speed: float) -> None:
    """Drive ahead until something ends the goal, and print what."""
    try:
        robot.do('drive_distance', distance=5.0, max_translation_speed=speed)
    except GoalFailed as stopped:
        print(stopped, flush=True)


def square(robot: GoalClient) -> None:
    for x, y in ((0.6, 0.0), (0.6, -0.6), (0.0, -0.6), (0.0, 0.0)):
        go_to(robot, x, y)


def circles(robot: GoalClient) -> None:
    for radius in (0.15, 0.25, 0.35):
        robot.do('drive_arc', angle=-tau, radius=radius, translate_direction=1)


def walls(robot: GoalClient) -> None:
    go_to(robot, *WALL_AHEAD)
    for _ in range(2):
        drive_until_stopped(robot, 0.2)
        robot.do('drive_distance', distance=-0.2)
        robot.do('rotate_angle', angle=pi / 2)


def doors(robot: GoalClient) -> None:
    for x, y in DOORS:
        go_to(robot, x, y)


def stairs(robot: GoalClient) -> None:
    """At a cliff the robot stops by itself, in Passive."""
    robot.do('rotate_angle', angle=pi / 2)
    drive_until_stopped(robot, EDGE_SPEED)
    robot.call('set_mode', mode=Mode.SAFE)
    robot.do('drive_distance', distance=-0.4)


STEPS = {'a square': square, 'three circles': circles, 'two walls': walls, 'two doors': doors,
         'the stairs': stairs}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args(remove_ros_args()[1:])
    with GoalClient() as robot:
        wait_for_robot(robot.node)
        robot.call('set_leds', play=True, power_color=0, power_intensity=255)
        robot.do('audio_note_sequence', notes='C5:0.2 E5:0.2 G5:0.2 C6:0.4')
        for name, step in STEPS.items():
            print(f'{name} ...', flush=True)
            step(robot)
        robot.call('set_leds', power_color=255, power_intensity=60)
        robot.do('audio_note_sequence', notes='G5:0.25 E5:0.25 C5:0.5')


if __name__ == '__main__':
    try:
        main()
    except GoalFailed as why:
        raise SystemExit(str(why)) from None
