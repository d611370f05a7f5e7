# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
#
# Source this from bash or zsh: a shell in which everything built here works.
#     source env.sh

if [ -z "${BASH_VERSION:-}${ZSH_VERSION:-}" ]; then
    echo 'env.sh is for bash and zsh' >&2
    return 1
fi
_create_root=$(cd "$(dirname "${BASH_SOURCE:-$0}")" > /dev/null && pwd -P)
if [ "$(cat "$_create_root/install/built" 2> /dev/null)" != "$_create_root" ]; then
    echo "create_oi_ros is not built: run make in $_create_root" >&2
    unset _create_root
    return 1
fi

# Both can be links: tools/folders.py. What stands in them has the real paths.
_create_venv=$(cd "$_create_root/.venv" > /dev/null && pwd -P)
_create_install=$(cd "$_create_root/install" > /dev/null && pwd -P)
if [ -f "$_create_venv/bin/colcon" ]; then  # ROS from wheels, not from /opt/ros
    _create_setup=local_setup
    export VIRTUAL_ENV="$_create_venv"
    export AMENT_PREFIX_PATH="$VIRTUAL_ENV" CMAKE_PREFIX_PATH="$VIRTUAL_ENV"
    # The wheels have one middleware, Fast DDS; with another name, rclpy.init() fails.
    unset RMW_IMPLEMENTATION
    # Without these two, the wheels' start-up hook sets them and starts Python again, every time.
    export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1
    case ":${LD_LIBRARY_PATH:-}:" in *":$VIRTUAL_ENV/lib:"*) ;; *)
        LD_LIBRARY_PATH="$VIRTUAL_ENV/lib$(
            printf ':%s' "$VIRTUAL_ENV"/lib/python3.*/site-packages/ros_*.libs
        )${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
        export LD_LIBRARY_PATH ;;
    esac
else
    _create_setup=setup  # sources the ROS that it was built with, too
fi

# colcon's scripts read unset variables, which `set -u` forbids.
case $- in *u*) _create_nounset=1; set +u ;; *) _create_nounset= ;; esac
if [ -n "${ZSH_VERSION:-}" ]; then
    . "$_create_install/$_create_setup.zsh"
else
    . "$_create_install/$_create_setup.bash"
fi
[ -z "$_create_nounset" ] || set -u

# Messages refuse a field that they do not have, and 1 for 1.0, which would arrive as 5e-324.
export ROS_PYTHON_CHECK_FIELDS="${ROS_PYTHON_CHECK_FIELDS:-1}"
export CREATE_OI_ENV="$_create_root/env.sh"  # create_run tells its user to source this
_create_bin="$_create_install/create_oi_ros/lib/create_oi_ros:$_create_venv/bin"
case ":$PATH:" in *":$_create_bin:"*) ;; *) export PATH="$_create_bin:$PATH" ;; esac
unset _create_root _create_venv _create_install _create_setup _create_bin _create_nounset
