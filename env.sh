# Source this from bash or zsh: a shell in which everything built here works.
#     source env.sh

_create_root=$(cd "$(dirname "${BASH_SOURCE:-$0}")" > /dev/null && pwd)
_create_shell=${ZSH_VERSION:+zsh}
_create_shell=${_create_shell:-bash}

if [ ! -f "$_create_root/install/built" ]; then
    echo "create_oi_ros is not built: run make build in $_create_root" >&2
    unset _create_root _create_shell
    return 1 2> /dev/null || exit 1
fi

if [ -f "$_create_root/.venv/bin/colcon" ]; then  # ROS from wheels, not from /opt/ros
    export VIRTUAL_ENV="$_create_root/.venv"
    export AMENT_PREFIX_PATH="$VIRTUAL_ENV" CMAKE_PREFIX_PATH="$VIRTUAL_ENV"
    # The wheels' start-up hook would set these two and start Python again, every time.
    export LD_LIBRARY_PATH="$VIRTUAL_ENV/lib:$(echo "$VIRTUAL_ENV"/lib/python3.*/site-packages/ros_*.libs | tr ' ' :)"
    export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1
    # They hold one middleware, Fast DDS; asked for another, rclpy.init() fails.
    unset RMW_IMPLEMENTATION
fi

. "$_create_root/install/local_setup.$_create_shell"
PATH="$_create_root/install/create_oi_ros/lib/create_oi_ros:$_create_root/.venv/bin:$PATH"
export PATH
unset _create_root _create_shell
