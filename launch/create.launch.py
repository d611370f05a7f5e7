# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
One Create: its driver and model, and on request a simulated robot and RViz.

    ros2 launch create_oi_ros create.launch.py port:=/dev/ttyUSB0
    ros2 launch create_oi_ros create.launch.py simulated:=true rviz:=true
    ros2 launch create_oi_ros create.launch.py simulated:=true web:=true
"""

import os
import shutil
import tempfile

from ament_index_python.packages import (
    get_package_prefix,
    get_package_share_directory,
    PackageNotFoundError,
)
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    OpaqueFunction,
    RegisterEventHandler,
)
from launch.event_handlers import OnProcessIO
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

SHARE = get_package_share_directory('create_oi_ros')
ARGUMENTS = {
    'port': ('/dev/ttyUSB0', 'serial device of the robot, or a pyserial URL'),
    'simulated': ('false', 'true: simulate the robot, on a pseudo terminal'),
    'world': ('apartment', 'world of the simulated robot'),
    'namespace': ('', 'namespace of all nodes and topics'),
    'frame_prefix': ('', 'put before every frame, such as robot1/'),
    'capture': ('', 'file to write every byte of the serial line to'),
    'params': (os.path.join(SHARE, 'config', 'create.yaml'), 'parameter file of the driver'),
    'description': ('true', 'true: publish the model and its frames (robot_state_publisher)'),
    'rviz': ('false', 'true: open RViz'),
    'web': ('false', 'true: serve a page that shows the robot and drives it (create_web)'),
    'host': ('127.0.0.1', 'address on which the page is served; 0.0.0.0: with a token'),
}


SWITCHES = {'true': True, '1': True, 'yes': True, 'false': False, '0': False, 'no': False}
# Launch leaves its processes running when it fails. These end with it, however it ends.
ENDS_WITH_LAUNCH = [
    'setpriv --pdeathsig TERM ' if shutil.which('setpriv') else '',
    LaunchConfiguration('launch-prefix', default='')]
LINGER = 3  # seconds; less than the 5 after which launch kills


def nodes(context):
    """Check all arguments, then return what they ask for: so a wrong one starts nothing."""
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    asked = {name: switch(name, value[name])
             for name in ('simulated', 'description', 'rviz', 'web')}
    check(value, asked)
    namespace, prefix, port = value['namespace'], value['frame_prefix'], value['port']
    if asked['simulated']:
        name = namespace.strip('/').replace('/', '_') or 'robot'
        port = os.path.join(tempfile.gettempdir(), f'create_{name}_{os.getpid()}')
    made = [driver(value, port)]
    if asked['simulated']:
        watched = ['--control', control(port)] if asked['web'] else []
        made = simulated(port, value['world'], made, watched)
    if asked['web']:
        made.append(page(value, control(port) if asked['simulated'] else None))
    if asked['description']:
        with open(os.path.join(SHARE, 'urdf', 'create.urdf')) as model:
            made.append(Node(
                package='robot_state_publisher', executable='robot_state_publisher',
                exec_name='robot_state_publisher', namespace=namespace, prefix=ENDS_WITH_LAUNCH,
                parameters=[{'robot_description': model.read(), 'frame_prefix': prefix}]))
    if asked['rviz']:
        made.append(Node(
            package='rviz2', executable='rviz2', exec_name='rviz2', namespace=namespace,
            prefix=ENDS_WITH_LAUNCH,
            arguments=['-d', os.path.join(SHARE, 'rviz', 'create.rviz'), '-f', f'{prefix}odom']))
    return made


def switch(name, text):
    """Return whether an argument says true."""
    if text.lower() not in SWITCHES:
        raise RuntimeError(f'{name}:={text}; allowed: true or false')
    return SWITCHES[text.lower()]


def check(value, asked):
    """Raise RuntimeError if an argument is wrong, or asks for what is not installed."""
    for name, package in (('description', 'robot_state_publisher'), ('rviz', 'rviz2')):
        if asked[name]:
            check_installed(package, name)
    check_file(value['params'])
    if not value['port'] and not asked['simulated']:
        raise RuntimeError('port:= is empty; allowed: a serial device or a pyserial URL')


def check_installed(package, argument):
    """Raise RuntimeError if a package is missing."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        raise RuntimeError(
            f'{package} is not installed: sudo apt-get install '
            f'ros-jazzy-{package.replace("_", "-")}, or launch with {argument}:=false') from None


def check_file(path):
    """Raise RuntimeError if the parameter file cannot be read."""
    try:
        open(path).close()
    except OSError as error:
        raise RuntimeError(f'params:={path}: {error.strerror}') from None


def driver(value, port):
    """Return the driver; when it ends, the launch ends."""
    prefix = value['frame_prefix']
    return Node(
        package='create_oi_ros', executable='create_node', exec_name='create_node',
        namespace=value['namespace'], output='screen', prefix=ENDS_WITH_LAUNCH,
        parameters=[value['params'], {
            'port': port, 'odom_frame': f'{prefix}odom', 'base_frame': f'{prefix}base_footprint',
            # Launch does not pass an empty value on as a string.
            **({'capture': value['capture']} if value['capture'] else {})}],
        on_exit=EmitEvent(event=Shutdown(reason='create_node has ended')))


def control(port):
    """Return the control socket of the simulated robot on a port."""
    return f'{port}.control'


def page(value, socket):
    """Return the web page; `socket` is the control socket of a simulated robot, or None."""
    return Node(
        package='create_oi_ros', executable='create_web', exec_name='create_web',
        namespace=value['namespace'], output='screen', prefix=ENDS_WITH_LAUNCH,
        arguments=['--host', value['host'], *(['--control', socket] if socket else [])])


def simulated(port, world, users, options=()):
    """
    Return a simulated robot, and what is started when its port is there.

    create_sim is no ROS node and takes no --ros-args. It ends when the driver has closed the port.
    """
    program = os.path.join(
        get_package_prefix('create_oi_ros'), 'lib', 'create_oi_ros', 'create_sim')
    simulator = ExecuteProcess(
        cmd=[program, '--link', port, '--world', world, '--linger', str(LINGER), *options],
        name='create_sim', output='screen', prefix=ENDS_WITH_LAUNCH,
        on_exit=EmitEvent(event=Shutdown(reason='create_sim has ended')))
    waiting = list(users)

    def start(_):
        started = waiting.copy()
        waiting.clear()
        return started
    return [RegisterEventHandler(OnProcessIO(target_action=simulator, on_stdout=start)), simulator]


def generate_launch_description():
    """Declare the arguments and start the nodes."""
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=default, description=description)
          for name, (default, description) in ARGUMENTS.items()),
        OpaqueFunction(function=nodes)])
