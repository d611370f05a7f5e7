"""
One Create: its driver and model, and on request a simulated robot and RViz.

    ros2 launch create_oi_ros create.launch.py port:=/dev/ttyUSB0
    ros2 launch create_oi_ros create.launch.py simulated:=true rviz:=true
"""

import os
import tempfile

from ament_index_python.packages import get_package_prefix, get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, ExecuteProcess, OpaqueFunction
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

SHARE = get_package_share_directory('create_oi_ros')
ARGUMENTS = {
    'port': ('/dev/ttyUSB0', 'serial device of the robot, or a pyserial URL'),
    'simulated': ('false', 'true: simulate the robot, on a pseudo terminal'),
    'world': ('room', 'world of the simulated robot'),
    'namespace': ('', 'namespace of all nodes and topics'),
    'frame_prefix': ('', 'put before every frame, such as robot1/'),
    'capture': ('', 'file to write every byte of the serial line to'),
    'params': (os.path.join(SHARE, 'config', 'create.yaml'), 'parameter file of the driver'),
    'description': ('true', 'true: publish the model and its frames (robot_state_publisher)'),
    'rviz': ('false', 'true: open RViz'),
}


def nodes(context):
    """Return the nodes that the arguments ask for."""
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    asked = {name: value[name].lower() in ('true', '1', 'yes')
             for name in ('simulated', 'description', 'rviz')}
    namespace, prefix, port = value['namespace'], value['frame_prefix'], value['port']
    made = []
    if asked['simulated']:
        name = namespace.strip('/').replace('/', '_') or 'robot'
        port = os.path.join(tempfile.gettempdir(), f'create_{name}_{os.getpid()}')
        made.append(simulator(port, value['world']))
    made.append(Node(
        package='create_oi_ros', executable='create_node', namespace=namespace, output='screen',
        parameters=[value['params'], {
            'port': port, 'odom_frame': f'{prefix}odom', 'base_frame': f'{prefix}base_footprint',
            # Launch does not pass an empty value on as a string.
            **({'capture': value['capture']} if value['capture'] else {})}],
        on_exit=EmitEvent(event=Shutdown(reason='create_node has ended'))))
    if asked['description']:
        with open(os.path.join(SHARE, 'urdf', 'create.urdf')) as model:
            made.append(Node(
                package='robot_state_publisher', executable='robot_state_publisher',
                namespace=namespace,
                parameters=[{'robot_description': model.read(), 'frame_prefix': prefix}]))
    if asked['rviz']:
        made.append(Node(
            package='rviz2', executable='rviz2', namespace=namespace,
            arguments=['-d', os.path.join(SHARE, 'rviz', 'create.rviz'), '-f', f'{prefix}odom']))
    return made


def simulator(port, world):
    """Return the process of a simulated robot, which is no ROS node and takes no --ros-args."""
    program = os.path.join(
        get_package_prefix('create_oi_ros'), 'lib', 'create_oi_ros', 'create_sim')
    return ExecuteProcess(cmd=[program, '--link', port, '--world', world], output='screen')


def generate_launch_description():
    """Declare the arguments and start the nodes."""
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=default, description=description)
          for name, (default, description) in ARGUMENTS.items()),
        OpaqueFunction(function=nodes)])
