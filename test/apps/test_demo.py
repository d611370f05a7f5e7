# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The demo: the pilot, a short demo as a user sees it, and how it ends."""

from contextlib import closing
from math import hypot, pi
import os
from pathlib import Path
import signal
import subprocess
import sys

from create_oi_msgs.msg import Mode
from nav_msgs.msg import Odometry
import pytest

pytest.importorskip('rosbags', reason='no rosbags here: see tools/pins.txt')

from create_oi_ros.apps.demo import cliff, Pilot, TourError, WORLD
from create_oi_ros.apps.report.bag_reader import read
from create_oi_ros.ros.goal_client import GoalFailed
from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.ros.topics import PUBLISHED
from create_oi_ros.sim.world import Pose, shipped
from support.ros import children_of, Listener, scene

STAIRS_AHEAD = Pose(4.25, 4.85, pi / 2)
"""In the demo's world, ten centimetres before the robot sees the stairs."""


@pytest.fixture(scope='module')
def stage(tmp_path_factory):
    """Return a scene with a robot in the demo's world, and its node."""
    with scene(tmp_path_factory.mktemp('demo')) as made:
        made.hero = made.robot(world=shipped(WORLD))
        made.node(made.hero.link)
        yield made


@pytest.fixture(scope='module')
def pilot(stage):
    """Return a pilot, once the robot answers."""
    made = Pilot(stage.ros.node, stage.ros._executor, lambda: None)
    made.until(lambda: made.odom and made.mode == Mode.SAFE, 'the robot answers', 30.0)
    return made


def test_a_pilot_goes_where_it_is_told_and_turns_the_short_way(pilot, stage):
    pilot.go_to(0.3, 0.0)
    assert hypot(pilot.place[0] - 0.3, pilot.place[1]) < 0.05
    assert pilot.standing
    truth = stage.hero.body.truth
    before = truth().turned
    pilot.turn_to(pilot.yaw - pi / 2)
    assert truth().turned - before == pytest.approx(-pi / 2, abs=0.1)


def test_the_robot_comes_back_from_the_stairs(pilot, stage):
    robot = stage.hero
    robot.soon(lambda: robot.body.place(STAIRS_AHEAD))
    cliff(pilot)
    assert pilot.mode == Mode.SAFE
    assert not robot.body.sense().drop_caster and not robot.body.sense().cliff_front_left


def test_a_timeout_names_the_event_and_stops_the_robot(pilot, stage):
    pilot.command(0.1, 0.0)
    with pytest.raises(TourError, match='a miracle did not happen within 1 s'):
        pilot.until(lambda: False, 'a miracle', 1.0)
    stage.ros.until(lambda: pilot.standing)


def test_a_refusal_has_the_text_of_the_service(pilot):
    with pytest.raises(GoalFailed, match='play_song: '):
        pilot.call('play_song', number=99)


def demo(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """Start the demo, by somebody who has chosen a ROS domain."""
    return subprocess.Popen(
        [sys.executable, '-c', PROGRAMS['create_demo'], '-o', str(folder), *arguments],
        env={**os.environ, 'ROS_DOMAIN_ID': '7', 'PYTHONUNBUFFERED': '1'}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


@pytest.mark.nightly
def test_a_short_demo_ends_with_a_bag_and_its_report(tmp_path):
    shown = demo(tmp_path / 'demo', '--short')
    printed, _ = shown.communicate(timeout=60)
    assert shown.returncode == 0, printed
    assert '3 of 3: another tune' in printed and str(tmp_path / 'demo' / 'report.html') in printed
    assert (tmp_path / 'demo' / 'report.html').exists()
    recording = read(tmp_path / 'demo' / 'create_demo', lambda part: None)
    assert len(recording.spans['song']) == 2
    assert abs(recording.odom['yaw'][-1]) == pytest.approx(pi, abs=0.1)
    assert recording.settings['version'] and recording.settings['cmd_vel_timeout'] == '0.5'
    metadata = (tmp_path / 'demo' / 'create_demo' / 'metadata.yaml').read_text()
    for name in (*(topic.name for topic in PUBLISHED), 'cmd_vel', 'robot_description'):
        assert f'name: /{name.lstrip("/")}\n' in metadata


def test_a_demo_takes_its_own_domain_and_ctrl_c_leaves_no_process_and_a_readable_bag(tmp_path):
    shown = demo(tmp_path / 'demo')
    assert shown.stdout is not None
    domain = int(next(line for line in shown.stdout if 'ROS_DOMAIN_ID' in line).rpartition('=')[2])
    assert domain != 7, 'another robot may be there'
    with closing(Listener(domain)) as joined:
        odom = joined.listen(Odometry, 'odom')
        joined.until(lambda: odom)
    for line in shown.stdout:
        if 'a square' in line:
            break
    children = children_of(shown.pid)
    assert len(children) == 2
    shown.send_signal(signal.SIGINT)
    printed, _ = shown.communicate(timeout=20)
    assert shown.returncode == 130
    assert 'stopped' in printed and 'Traceback' not in printed
    assert not any(Path(f'/proc/{child}').exists() for child in children)
    assert len(read(tmp_path / 'demo' / 'create_demo', lambda part: None).odom) > 10


def test_an_existing_folder_is_left_alone(tmp_path):
    shown = demo(tmp_path)
    printed, _ = shown.communicate(timeout=20)
    assert shown.returncode == 2 and 'is there already' in printed
