# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Install create_oi_ros as an ament_python package."""

from glob import glob

from setuptools import find_packages, setup

NAME = 'create_oi_ros'
SHARE = f'share/{NAME}'

setup(
    name=NAME,
    version='1.0.0',
    packages=find_packages(include=[NAME, f'{NAME}.*']),
    package_data={NAME: ['py.typed', 'sim/world/shipped/*.world', 'apps/web/page/*.*',
                         'apps/report/live/*.*', 'pages/parts/*.*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (SHARE, ['package.xml']),
        *((f'{SHARE}/{folder}', glob(f'{folder}/*.*'))
          for folder in ('launch', 'config', 'config/with', 'urdf', 'rviz')
          if glob(f'{folder}/*.*')),
    ],
    install_requires=['setuptools'],
    python_requires='>=3.11',
    extras_require={'test': ['pytest']},  # by which `colcon test` knows how to run the tests
    zip_safe=True,
    author='create_oi_ros contributors',
    maintainer='create_oi_ros contributors',
    maintainer_email='create-oi-ros@example.com',
    description='A ROS 2 driver for the iRobot Create (Open Interface), with a simulated robot.',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'create_check = create_oi_ros.ros.programs:create_check',
            'create_lidar = create_oi_ros.ros.programs:create_lidar',
            'create_node = create_oi_ros.ros.programs:create_node',
            'create_record = create_oi_ros.ros.programs:create_record',
            'create_report = create_oi_ros.ros.programs:create_report',
            'create_run = create_oi_ros.ros.programs:create_run',
            'create_sim = create_oi_ros.ros.programs:create_sim',
            'create_web = create_oi_ros.ros.programs:create_web',
        ],
    },
)
