"""`create_run` as a user sees it: one command, a robot that can be driven, a clean end."""

from pathlib import Path
import re
import signal

from create_oi_msgs.msg import Mode
from nav_msgs.msg import Odometry
import pytest

from create_oi_ros.apps.run import introduction
from create_oi_ros.oi.tools.capture_format import CaptureReader, RecordKind, records_of
from create_oi_ros.ros.topics import LATCHED
from support.ros import scene


@pytest.fixture
def stage(tmp_path):
    """Return an empty scene."""
    with scene(tmp_path) as made:
        yield made


def children_of(pid: int) -> list[int]:
    """Return the processes that a process has started."""
    listed = Path(f'/proc/{pid}/task/{pid}/children').read_text()
    return [int(child) for child in listed.split()]


def test_it_starts_a_robot_that_drives_and_ends_cleanly(stage):
    run = stage.program('create_run', '--world', 'empty')
    odom = stage.ros.listen(Odometry, 'odom')
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: modes and modes[-1].mode == Mode.SAFE and odom)
    assert f'ROS domain {stage.domain}' in run.output
    steady = re.compile(r'6\d frames/s  SAFE .* faults 0 frames 0 bytes')
    stage.ros.until(lambda: steady.search(run.output))
    example = stage.example('drive.py')
    stage.ros.until(lambda: odom[-1].pose.pose.position.x > 0.2)
    assert example.ended() == 0
    assert 'Point(x=' in example.output
    children = children_of(run.pid)
    assert len(children) == 2
    run.send(signal.SIGINT)
    assert run.ended() == 0
    assert 'Traceback' not in run.output
    assert not any(Path(f'/proc/{child}').exists() for child in children)


def test_commands_to_try_work_in_a_path_with_a_space(monkeypatch):
    monkeypatch.setenv('CREATE_OI_ENV', '/home/me/my clone/env.sh')
    text = introduction('/tmp/port', simulated=True)
    assert ("source '/home/me/my clone/env.sh' && python '/home/me/my clone/examples/drive.py'\n"
            in text)


def test_capture_is_passed_on_to_the_node(stage):
    path = stage.folder / 'walk.capture'
    run = stage.program('create_run', '--world', 'empty', '--capture', str(path))
    stage.ros.until(lambda: 'robot answers' in run.output)
    run.send(signal.SIGINT)
    assert run.ended() == 0
    *_, last = records_of([path.read_bytes()], CaptureReader())
    assert last.kind is RecordKind.END


def test_a_missing_port_is_reported_and_run_continues(stage):
    run = stage.program('create_run', '--port', str(stage.folder / 'nothing'))
    stage.ros.until(lambda: 'does not exist' in run.output and 'NO ROBOT' in run.output)
    run.send(signal.SIGINT)
    assert run.ended() == 0


def test_children_end_with_it_even_when_it_is_killed(stage):
    run = stage.program('create_run', '--world', 'empty')
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    stage.ros.until(lambda: modes and modes[-1].mode == Mode.SAFE)
    children = children_of(run.pid)
    run.send(signal.SIGKILL)
    stage.ros.until(lambda: not any(Path(f'/proc/{child}').exists() for child in children))


def test_when_a_child_ends_everything_ends(stage):
    run = stage.program('create_run', '--world', 'no such world')
    assert run.ended() == 1
    assert 'create_sim has ended' in run.output

