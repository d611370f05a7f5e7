# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The launch files and the documented commands, by the real `ros2`, which asks what came of it."""

from collections.abc import Sequence
import os
from pathlib import Path
import re
import signal
import tempfile

from create_oi_msgs.srv import DefineSong
from nav_msgs.msg import Odometry
import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
import yaml

from create_oi_ros.ros.topics import LATCHED
from support.ros2 import Launch, Ros2
from support.source import blocks, PACKAGE, ROOT, ros2_commands
from tf2_msgs.msg import TFMessage

CREATE, SIMULATION, FLEET = (
    (PACKAGE, f'{name}.launch.py') for name in ('create', 'simulation', 'fleet'))
REAL, WITH_RVIZ, WITH_FILE, OF_THREE, ARGUMENTS = DONE = (
    (*CREATE, 'port:=PORT'), (*CREATE, 'port:=PORT', 'rviz:=true'),
    (*CREATE, 'params:=my_create.yaml'), (*FLEET, 'count:=3'), (*CREATE, '--show-args'))
"""Documented launches that have a test of their own."""
DOCUMENTED = [words[2:] for words in ros2_commands() if words[1:3] == ('launch', CREATE[0])]
OTHERS = [words for words in DOCUMENTED if words not in DONE]
ANSWERS = 'robot answers; entering SAFE'
"""The driver's words when a robot is there."""
MISTAKE = re.compile(r'\[WARN\] .*(another node|publish|subscribe|remap|parameter).*')
"""A warning that is not of a slow computer, such as of frames that are late."""


@pytest.fixture(scope='module')
def ports(ros2):
    """Return the ports of two robots that no launch file starts."""
    return ros2.stage.robot('one').link, ros2.stage.robot('two').link


def at(port: Path, words: Sequence[str]) -> list[str]:
    """Return a documented launch for this port."""
    return [word.replace('PORT', str(port)) for word in words]


def wait_for_nodes(ros2: Ros2, *names: str) -> None:
    """Wait until the graph has these nodes, and no other but that of the test."""
    wanted = sorted([*names, '/listener'])

    def wanted_only(shown: str) -> bool:
        found = sorted(line for line in shown.splitlines() if line.startswith('/'))
        if found != wanted and {*found} >= {*wanted}:  # the daemon may keep what has ended
            ros2.run('daemon', 'stop')
        return found == wanted
    ros2.run('node', 'list', shows=wanted_only)


def port_of(namespace: str, domain: int) -> Path:
    """Return the path of a simulated robot's port."""
    return Path(tempfile.gettempdir(), f'create_{domain}{namespace.replace("/", ".")}')


def ends_quietly(launch: Launch) -> None:
    """Press Ctrl-C; no driver has seen a mistake, and they end well, as their robots do."""
    assert not MISTAKE.findall(launch.output)
    launch.interrupt()
    died = re.search(r'\[create_(node|sim)-\d+\]: process has died', launch.output)
    assert not died, launch.output


def test_the_launches_that_are_tested_are_documented():
    assert {*DONE} <= {*DOCUMENTED}


def test_driver_model_and_rviz_are_launched(ros2, ports):
    launch = ros2.launch(*at(ports[0], WITH_RVIZ))
    launch.until(ANSWERS)
    wait_for_nodes(ros2, '/create', '/create_cmd_vel')
    assert ros2.run('param', 'get', '/create', 'port').strip() == f'String value is: {ports[0]}'
    model, = launch.started('robot_state_publisher')
    assert model.parameters['robot_description'].startswith('<?xml')
    assert model.parameters['frame_prefix'] == ''
    assert '/tf:=/tf' in model.rules
    rviz, = launch.started('rviz2')
    assert rviz.arguments[0] == '-d' and Path(rviz.arguments[1]).is_file()
    assert rviz.arguments[2:] == ['-f', 'odom']
    ends_quietly(launch)


def test_a_parameter_file_wins_over_defaults_and_a_given_argument_over_the_file(
        ros2, ports, monkeypatch):
    monkeypatch.chdir(ros2.stage.folder)
    of_file = {'port': str(ports[0]), 'odom_frame': 'wheels', 'base_frame': 'body',
               'gyro': 'analog', 'capture': 'a', 'use_sim_time': True}
    Path('my_create.yaml').write_text(yaml.safe_dump({'/create': {'ros__parameters': of_file}}))
    launch = ros2.launch(*WITH_FILE)
    launch.until(ANSWERS)
    assert ros2.stage.ros.parameters('/create', *of_file) == [*of_file.values()]
    launch.interrupt()
    given = {'port': str(ports[1]), 'gyro': 'none', 'capture': 'b'}
    launch = ros2.launch(
        *WITH_FILE, 'frame_prefix:=r/', 'use_sim_time:=False', 'rviz:=True',
        *(f'{name}:={value}' for name, value in given.items()))
    launch.until(ANSWERS)
    found = dict(zip(of_file, ros2.stage.ros.parameters('/create', *of_file), strict=True))
    assert found == given | {
        'odom_frame': 'r/odom', 'base_frame': 'r/base_footprint', 'use_sim_time': False}
    for name in ('robot_state_publisher', 'rviz2'):
        assert launch.started(name)[0].parameters['use_sim_time'] is False
    ends_quietly(launch)


def test_a_simulated_robot_is_launched_in_a_namespace_with_frames_of_its_own(ros2):
    stage, port = ros2.stage, port_of('/lab/robot1', ros2.stage.domain)
    scans = stage.ros.listen(LaserScan, '/lab/robot1/scan', qos_profile_sensor_data)
    static = stage.ros.listen(TFMessage, '/lab/robot1/tf_static', LATCHED)
    moving = stage.ros.listen(TFMessage, '/lab/robot1/tf')
    launch = ros2.launch(
        *SIMULATION, 'namespace:=lab/robot1', 'frame_prefix:=robot1/', 'tf:=tf', 'lidar:=true',
        'web:=true', 'world:=room', 'gyro:=analog')
    launch.until(ANSWERS)
    launch.until('open http://')
    wait_for_nodes(ros2, *(f'/lab/robot1/{name}' for name in (
        'create', 'create_cmd_vel', 'create_lidar', 'create_web')))
    assert ros2.stage.ros.parameters('/lab/robot1/create', 'port', 'gyro') == [str(port), 'analog']
    assert port.is_symlink() and Path(f'{port}-control').is_socket()
    assert f'--control {port}-control' in Path(
        f'/proc/{launch.pid("create_web")}/cmdline').read_text().replace('\0', ' ')
    transform = stage.ros.until(lambda: moving)[0].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == (
        'robot1/odom', 'robot1/base_footprint')
    lidar = stage.ros.until(lambda: static)[0].transforms[0]
    assert (lidar.header.frame_id, lidar.child_frame_id) == (
        'robot1/base_footprint', 'robot1/laser')
    assert stage.ros.until(lambda: scans)[0].header.frame_id == 'robot1/laser'
    model, = launch.started('robot_state_publisher')
    assert '__ns:=/lab/robot1' in model.rules and '/tf_static:=tf_static' in model.rules
    assert model.parameters['frame_prefix'] == 'robot1/'
    ends_quietly(launch)
    assert not port.is_symlink() and not Path(f'{port}-control').exists()


def test_each_robot_of_a_fleet_has_its_namespace_and_frames_and_follows_its_own_commands(ros2):
    ros, names = ros2.stage.ros, ('robot1', 'robot2', 'robot3')
    heard = {name: ros.listen(Odometry, f'/{name}/odom', 1) for name in names}
    launch = ros2.launch(*OF_THREE)
    launch.until(ANSWERS, 3)
    wait_for_nodes(ros2, *(f'/{name}/{node}' for name in names
                           for node in ('create', 'create_cmd_vel')))
    assert ros2.run('param', 'get', '/robot2/create', 'odom_frame').strip() == (
        'String value is: robot2/odom')
    ros.drive(0.2, 0.0, lambda: all(heard.values())
              and heard['robot2'][-1].pose.pose.position.x > 0.2, '/robot2/cmd_vel')
    for name, messages in heard.items():
        last = messages[-1]
        assert (last.header.frame_id, last.child_frame_id) == (
            f'{name}/odom', f'{name}/base_footprint')
        assert name == 'robot2' or last.pose.pose.position.x == 0
    models = launch.started('robot_state_publisher', 3)
    assert {model.parameters['frame_prefix'] for model in models} == {f'{n}/' for n in names}
    ends_quietly(launch)


PYTHON = """
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription, LogInfo
from launch.substitutions import LaunchConfiguration

def ours(name, **arguments):
    share = get_package_share_directory('create_oi_ros')
    return IncludeLaunchDescription(
        os.path.join(share, 'launch', name + '.launch.py'), launch_arguments=arguments.items())

def generate_launch_description():
    return LaunchDescription([
        IncludeLaunchDescription('page.launch.xml'), IncludeLaunchDescription('house.launch.yaml'),
        ours('simulation', namespace='red', frame_prefix='red/', tf='tf', description='false'),
        ours('simulation', namespace='/deep/blue', frame_prefix='blue/', tf='/tf'),
        ours('create', namespace='hall', frame_prefix='', params='hall.yaml'),
        LogInfo(msg=['web: ', LaunchConfiguration('web', default='not set')])])
"""
YAML = """
launch:
- group:
  - push_ros_namespace: {namespace: house}
  - set_remap: {from: cmd_vel, to: wheels}
  - include:
      file: $(find-pkg-share create_oi_ros)/launch/simulation.launch.py
      arg:
      - {name: namespace, value: kitchen}
      - {name: frame_prefix, value: kitchen/}
"""


def test_other_launch_files_include_these(ros2, ports, monkeypatch):
    monkeypatch.chdir(ros2.stage.folder)
    page, hall = map(str, ports)
    xml, = (block.text for block in blocks(ROOT / 'docs' / 'several_robots.md')
            if block.language == 'xml')
    Path('all.launch.py').write_text(PYTHON)
    Path('page.launch.xml').write_text(xml.replace('/dev/ttyUSB0', page))
    Path('house.launch.yaml').write_text(YAML)
    Path('hall.yaml').write_text(yaml.safe_dump({'/hall/create': {'ros__parameters': {
        'port': hall, 'odom_frame': 'hall', 'base_frame': 'hall/base'}}}))
    launch = ros2.launch('all.launch.py')
    launch.until(ANSWERS, 6)
    simulated = '/red', '/deep/blue', '/robot2', '/house/kitchen'
    places = (*simulated, '/hall', '/robot1')
    wait_for_nodes(ros2, *(f'{place}/{node}' for place in places
                           for node in ('create', 'create_cmd_vel')))
    there = {*(f'{place}/odom' for place in places), '/house/kitchen/wheels', '/red/tf', '/tf'}

    def topics() -> set[str]:
        return {name for name, _ in ros2.stage.ros.node.get_topic_names_and_types()}
    ros2.stage.ros.until(lambda: there <= topics())
    assert not {'/house/kitchen/cmd_vel', '/deep/blue/tf'} & topics()
    for place in simulated:
        assert port_of(place, ros2.stage.domain).is_symlink()
    assert ros2.stage.ros.parameters('/hall/create', 'port', 'odom_frame') == [hall, 'hall']
    assert 'web: not set' in launch.output
    ends_quietly(launch)


@pytest.mark.parametrize('words, sentence', [
    ((*CREATE, 'simulated:=true'),
     'simulated:=true: create.launch.py is for a real robot; launch simulation.launch.py'),
    ((*CREATE, 'params:=/nodir/x'), '--params-file /nodir/x: there is no such file'),
    ((*CREATE, 'respawn:=maybe'), 'Argument "respawn" provided value "maybe" is not valid'),
    ((*CREATE, 'namespace:=my robot'), 'The resulting namespace is invalid'),
    ((*CREATE, 'rviz:=true'), "package 'rviz2' not found"),
    ((*SIMULATION, 'world:=nowhere'),
     "--world: 'nowhere'; allowed: a file, or one of apartment, empty, room, table"),
    ((*FLEET, 'count:=0'), 'Argument "count" provided value "0" is not valid'),
])
def test_what_is_wrong_is_said_in_a_sentence_and_nothing_is_left(
        ros2, monkeypatch, words, sentence):
    if 'rviz:=true' in words:
        monkeypatch.setenv('AMENT_PREFIX_PATH', os.environ['AMENT_PREFIX_PATH'].partition(':')[2])
    launch = ros2.launch(*words)
    launch.ended()
    assert sentence in ' '.join(launch.output.split())


def test_a_killed_driver_ends_the_launch_or_starts_again(ros2, ports):
    for respawn in ([], ['respawn:=true']):
        launch = ros2.launch(*at(ports[0], REAL), *respawn)
        launch.until(ANSWERS)
        killed = launch.pid('create_node')
        os.kill(killed, signal.SIGKILL)
        if respawn:
            launch.until(ANSWERS, 2)
            assert launch.pid('create_node') != killed
            launch.interrupt()
        else:
            launch.ended()


@pytest.mark.parametrize('words, names', [
    (ARGUMENTS, 'port params namespace frame_prefix tf gyro capture use_sim_time log_level '
     'respawn description rviz web host control'),
    ((*SIMULATION, '--show-args'), 'namespace world lidar params frame_prefix rviz web'),
    ((*FLEET, '--show-args'), 'count')])
def test_the_arguments_are_shown(ros2, words, names):
    shown = ros2.run('launch', *words)
    assert all(f"    '{name}':\n" in shown for name in names.split())


@pytest.mark.parametrize('words', OTHERS, ids=' '.join)
def test_the_other_documented_launches_start_and_end(ros2, ports, monkeypatch, words):
    monkeypatch.chdir(ros2.stage.folder)
    launch = ros2.launch(*at(ports[0], words))
    launch.until(ANSWERS)
    ends_quietly(launch)


# The documented `ros2` commands, typed as they stand in the pages; only the port is another one.


LEFT_OUT = {
    'diagnostic_aggregator', 'foxglove_bridge', 'joy', 'nav2_bringup', 'nav2_map_server',
    'robot_localization', 'ros2bag', 'rqt_robot_monitor', 'slam_toolbox', 'sros2',
    'teleop_twist_joy', 'teleop_twist_keyboard', 'tf2_ros'}
"""Packages that are not here; commands that need one are not run."""
VERBS = {'bag': 'ros2bag', 'security': 'sros2'}
"""Words after `ros2` that another package brings."""
SHOWS = {
    'action list': '/drive_distance', 'action send_goal': 'status: SUCCEEDED',
    'daemon stop': 'daemon', 'interface show': '# ', 'node list': '/create\n',
    'param describe': 'seconds after the last', 'param list': 'cmd_vel_timeout',
    'param set': 'Set parameter successful', 'run create_node': 'robot answers',
    'run create_web': 'open http://', 'service call': 'success=True', 'service list': '/set_mode',
    'topic echo': '\n---\n', 'topic hz': 'average rate: ',
    'topic info': 'Node name: create_cmd_vel', 'topic list': '/odom', 'topic pub': 'publishing #3'}
"""Part of what each kind of command prints when it works."""
LASTING = {'run create_node', 'run create_web', 'topic echo', 'topic hz', 'topic pub'}
"""Those that run until Ctrl-C; others are repeated while the graph or the robot is not known."""


def kind(words):
    """Return the kind of a command: a key of SHOWS."""
    return f'run {words[3]}' if words[1] == 'run' else ' '.join(words[1:3])


def needs(words):
    """Return the package that a command needs."""
    return words[2] if words[1] in ('run', 'launch') else VERBS.get(words[1], PACKAGE)


DRIVER = ('ros2', 'run', PACKAGE, 'create_node', '--ros-args', '--params-file', 'my_create.yaml')
"""Starts the driver that the other commands ask."""
OURS = [words for words in ros2_commands()
        if needs(words) == PACKAGE and words[1] != 'launch' and words != DRIVER]
# The daemon is ended last; before it, what was learned is saved: the robot must have driven.
OURS.sort(key=lambda words: (words[1] == 'daemon', '/save_odometry_model' in words))


@pytest.fixture(scope='module')
def typed(ros2: Ros2):
    """Return a function that types a command, and waits until it has worked."""
    robot = ros2.stage.robot()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ros2.stage.folder)
        text = (ROOT / 'config' / 'create.yaml').read_text('utf-8')
        (ros2.stage.folder / 'my_create.yaml').write_text(text.replace(
            '/dev/ttyUSB0', str(robot.link)).replace('odometry_model: ""', 'odometry_model: "m"'))

        def run(words):
            given = [word.replace('PORT', str(robot.link)) for word in words[1:]]
            if kind(words) not in LASTING:
                ros2.run(*given, shows=lambda output: SHOWS[kind(words)] in output)
                return
            program = ros2.start(*given, terminal=True)
            ros2.stage.ros.until(
                lambda: SHOWS[kind(words)] in program.output.replace('\r', ''), ' '.join(words))
            program.type('\x03')
            program.ended()
        yield run


def test_each_command_is_run_or_its_package_is_listed():
    assert {needs(words) for words in ros2_commands()} == LEFT_OUT | {PACKAGE}
    assert DRIVER in ros2_commands()


@pytest.mark.parametrize('words', [words for words in OURS if words[1] == 'run'], ids=' '.join)
def test_a_program_is_started(typed, words):
    typed(words)


@pytest.fixture(scope='module')
def driver(ros2, typed):
    """Start a driver that the following commands ask, and have a song in the robot."""
    program = ros2.start(*DRIVER[1:])
    ros2.stage.ros.until(lambda: 'entering SAFE' in program.output)
    ros2.stage.ros.until(lambda: ros2.stage.ros.call(
        DefineSong, 'define_song', pitches=[60], seconds=[0.1]).success, 'the song is stored')


@pytest.mark.parametrize('words', [words for words in OURS if words[1] != 'run'], ids=' '.join)
def test_a_command_asks_or_moves_a_running_driver(driver, typed, words):
    typed(words)
