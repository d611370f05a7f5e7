# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""`create_view` as a user sees it: a real terminal, the real node, a simulated robot."""

import os
import re
import signal
import subprocess
import sys
import termios

from create_oi_msgs.msg import Mode
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
import pytest

from create_oi_ros.ros.programs import PROGRAMS
from create_oi_ros.ros.topics import LATCHED
from support.ros import children_of, scene
from support.screen import terminals

KEYS = 'q quit'


@pytest.fixture
def stage(tmp_path):
    """Return an empty scene."""
    with scene(tmp_path) as made:
        yield made


@pytest.fixture
def start_view(stage):
    """Return a function that starts a view in the scene."""
    with terminals('create_view', stage.domain) as start:
        yield start


def ready(stage, *remaps, **parameters):
    """Start a robot and its node; return both."""
    robot = stage.robot()
    node = stage.node(robot.link, *remaps, **parameters)
    return robot, node


def place(view) -> float:
    """Return the x that the screen shows."""
    found = re.match(r'x ([+-][\d.]+) ', view.screen.after('pose'))
    return float(found[1]) if found else 0.0


def hold(view, key, until, what):
    """
    Hold a key down until a condition holds.

    One press may come too early: discovery between view and driver may not be complete.
    """
    def repeated():
        view.type(key)
        return until()
    view.until(repeated, what)


def commanded(stage, type_=Twist, name='cmd_vel'):
    """Return a list that fills with velocity commands, once their publisher is known."""
    heard = stage.ros.listen(type_, name, 100)
    stage.ros.until(lambda: stage.ros.node.count_publishers(name), f'a publisher of {name}')
    return heard


def drive(stage, view, commands):
    """Hold a key down until another subscriber has received its command as well."""
    def heard():
        view.type('w')
        view.look()
        return '+0.200 m/s' in view.screen.after('cmd_vel') and any(
            command.linear.x > 0 for command in commands)
    stage.ros.until(heard, 'driving')


def safe(view):
    """Wait until the screen shows the robot in SAFE, and a driver subscribes to cmd_vel."""
    view.until(lambda: view.screen.after('mode') == 'SAFE' and view.screen.after('pose') != '-'
               and 'frames/s' in view.screen.after('link')
               and view.screen.after('cmd_vel') == 'none heard', 'a robot in SAFE')


def test_it_shows_drives_stops_and_leaves_the_terminal_as_it_was(stage, start_view):
    ready(stage)
    view = start_view()
    safe(view)
    commands = commanded(stage)
    assert KEYS in view.screen.text
    view.until(lambda: '%' in view.screen.after('battery'), 'a battery')
    hold(view, '\x1b[A', lambda: place(view) > 0.1
         and '+0.200 m/s' in view.screen.after('cmd_vel'), 'driving')
    hold(view, ' ', lambda: 'stop: done' in view.screen.text, 'a stop that is answered')
    view.until(lambda: view.screen.after('speed') == '+0.000 m/s +0.00 rad/s', 'standing')
    stage.ros.until(lambda: commands and commands[-1] == Twist())
    # Nothing more is published, so that others may drive.
    count = len(commands)
    odom = stage.ros.listen(Odometry, 'odom')
    view.type('p')
    view.until(lambda: view.screen.after('song') == 'plays', 'a song')
    stage.ros.until(lambda: len(odom) > 10)
    assert len(commands) == count
    assert commands[-2] != Twist()
    view.type('q')
    assert view.ended() == 0
    assert view.restored
    assert view.screen.outside == 0
    assert 'Traceback' not in view.output


def test_modes_are_asked_for_and_refusals_are_seen(stage, start_view):
    robot, _ = ready(stage)
    view = start_view()
    safe(view)
    view.type('1')
    view.until(lambda: view.screen.after('mode') == 'PASSIVE', 'PASSIVE')
    hold(view, 'p', lambda: 'define_song: refused' in view.screen.text, 'a refusal')
    view.type('2')
    view.until(lambda: view.screen.after('mode') == 'SAFE', 'SAFE')
    view.type('h')
    view.sees('forward, as long as it is held')
    view.type('q')
    assert view.ended() == 0


def test_a_key_that_is_let_go_drives_no_more(stage, start_view):
    ready(stage)
    view = start_view()
    safe(view)
    commands = commanded(stage)
    drive(stage, view, commands)
    stage.ros.until(lambda: commands and commands[-1] == Twist())
    assert view.process.poll() is None


def test_it_speaks_as_the_driver_listens_in_its_namespace(stage, start_view):
    ready(stage, '__ns:=/robot1', enable_stamped_cmd_vel=True)
    view = start_view('--ascii', '--ros-args', '-r', '__ns:=/robot1')
    safe(view)
    commands = commanded(stage, TwistStamped, '/robot1/cmd_vel')
    view.sees('/robot1/create')
    assert view.screen.text.isascii()
    hold(view, 'a', lambda: re.search(r'\+(0\.9|1\.0)\d rad/s', view.screen.after('speed')),
         'turning')
    stage.ros.until(lambda: commands)
    assert commands[-1].header.stamp.sec > 0


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops_the_robot_and_restores_the_terminal(stage, start_view, number):
    ready(stage)
    view = start_view()
    safe(view)
    commands = commanded(stage)
    drive(stage, view, commands)
    if number == signal.SIGINT:
        view.type('\x03')
    else:
        view.send(number)
    assert view.ended() == 0
    assert view.restored
    stage.ros.until(lambda: commands and commands[-1] == Twist())


def test_when_the_terminal_goes_the_robot_stops(stage, start_view):
    ready(stage)
    view = start_view()
    safe(view)
    commands = commanded(stage)
    drive(stage, view, commands)
    view.hang_up()
    assert view.process.wait(30) == 0
    stage.ros.until(lambda: commands and commands[-1] == Twist())


def test_without_a_driver_it_says_so_and_waits_for_one(stage, start_view):
    view = start_view()
    view.sees('Nothing heard yet')
    view.type('w')
    assert view.screen.after('cmd_vel') == 'nobody listens'
    view.type('2')
    view.sees('nobody offers')
    _, node = ready(stage)
    safe(view)
    node.send(signal.SIGINT)
    assert node.ended() == 0
    view.sees('nothing heard for')


def test_a_window_may_be_dragged(stage, start_view):
    view = start_view()
    view.sees(KEYS)
    view.resize(60, 20)
    view.sees('here are 60 x 20')
    view.resize(120, 40)
    view.until(lambda: KEYS in view.screen.text.split('\n')[-1], 'keys at the bottom')


@pytest.mark.parametrize(('terminal', 'complaint'), [
    ({}, 'it needs a terminal'), ({'TERM': 'dumb'}, 'cannot move its cursor')])
def test_where_there_is_no_terminal_it_says_so(stage, start_view, terminal, complaint):
    if terminal:
        view = start_view(**terminal)
        assert view.ended() == 2
        assert complaint in view.output
        assert view.restored
        return
    done = subprocess.run(
        [sys.executable, '-c', PROGRAMS['create_view']], text=True, capture_output=True,
        stdin=subprocess.DEVNULL, timeout=60, env={**os.environ, 'TERM': 'xterm'})
    assert (done.returncode, done.stdout) == (2, '')
    assert complaint in done.stderr
    assert 'Traceback' not in done.stderr


def test_a_stalled_terminal_does_not_keep_it_from_ending(stage, start_view):
    modes = stage.ros.listen(Mode, 'mode', LATCHED)
    odom = stage.ros.listen(Odometry, 'odom')
    ready(stage)
    stage.ros.until(lambda: modes and modes[-1].mode == Mode.SAFE)
    view = start_view(size=(200, 60))
    safe(view)
    begun = len(odom)

    def stalled() -> bool:
        # Whole pictures that nobody reads soon fill the buffer of the terminal.
        view.type('\x0cw')
        return len(odom) > begun + 150 and odom[-1].pose.pose.position.x > 0.05
    stage.ros.until(stalled)
    view.send(signal.SIGTERM)
    assert view.process.wait(30) == 0


@pytest.fixture
def start_shell(stage):
    """Return a function that starts a shell with job control on a terminal."""
    with terminals('bash', stage.domain) as start:
        yield start


def local_flags(shell) -> int:
    """Return the terminal's flags for echo, lines and signals."""
    return termios.tcgetattr(shell.slave)[3]


@pytest.mark.parametrize('asked_by', ['key', 'signal'])
def test_ctrl_z_stops_the_wheels_and_fg_goes_on(stage, start_shell, asked_by):
    ready(stage)
    shell = start_shell(PS1='$ ')
    shell.until(lambda: '$ ' in shell.output, 'a prompt')
    before = local_flags(shell)
    shell.type(f'{sys.executable} -c "{PROGRAMS["create_view"]}"\n')
    safe(shell)
    commands = commanded(stage)
    drive(stage, shell, commands)
    if asked_by == 'key':
        shell.type('w\x1a')
    else:
        shell.type('w')
        view, = children_of(shell.process.pid)
        os.kill(view, signal.SIGTSTP)
    shell.until(lambda: 'Stopped' in shell.output, 'the shell tells of a stopped job')
    stage.ros.until(lambda: commands[-1] == Twist(), 'a last zero')
    assert not shell.screen.alternate
    assert local_flags(shell) == before
    # Typed to the shell, `fg` is no key of the view: the robot does not dock.
    shell.type('fg\n')
    safe_again = len(shell.output)
    shell.until(lambda: shell.screen.alternate and KEYS in shell.screen.text, 'the picture')
    assert 'dock' not in shell.output[safe_again:].replace('g g dock', '')
    shell.type('q')
    shell.until(lambda: not shell.screen.alternate, 'the end')
    shell.type('exit\n')
    assert shell.ended() == 0


def test_the_robot_docks_when_g_is_pressed_twice(stage, start_view):
    ready(stage)
    view = start_view()
    safe(view)
    view.type('g')
    view.sees('press g again within a second')
    view.type('x')
    assert 'dock:' not in view.screen.text

    view.type('gg')
    view.sees('dock: under way')
    view.type(' ')
    view.sees('dock: stopped after')


def test_a_key_drives_a_set_way_and_the_result_is_shown(stage, start_view):
    ready(stage)
    view = start_view()
    safe(view)

    def under_way():
        view.type('i')
        return 'drive_distance: under way' in view.screen.text
    view.until(under_way, 'the goal runs')
    view.sees('drive_distance: done, drove 0.')
