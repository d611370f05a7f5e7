# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
#
# The driver on an installed ROS 2 Jazzy, amd64 or arm64. docs/container.md has the commands.
FROM ros:jazzy
SHELL ["/bin/bash", "-c"]
WORKDIR /ws
COPY . src/create_oi_ros
RUN apt-get update \
    && rosdep update \
    && rosdep install -y --ignore-src --from-paths src/create_oi_ros src/create_oi_ros/msg_defs \
    && rm -rf /var/lib/apt/lists/*
RUN source /opt/ros/jazzy/setup.bash \
    && colcon build --base-paths src/create_oi_ros src/create_oi_ros/msg_defs
STOPSIGNAL SIGINT
ENTRYPOINT ["/bin/bash", "-c", "source /ws/install/setup.bash && exec \"$@\"", "--"]
CMD ["ros2", "launch", "create_oi_ros", "simulation.launch.py"]
