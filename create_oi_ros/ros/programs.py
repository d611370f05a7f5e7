"""
The executables: quiet while they load.

Loading rclpy takes most of a second, in which Ctrl-C would print a traceback from the depths of
an import. Nothing has been started yet, so the plain way of ending is right.
"""

from collections.abc import Iterator
from contextlib import contextmanager
import signal


@contextmanager
def _loading() -> Iterator[None]:
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or not error.name.startswith('create_oi_msgs'):
            raise
        raise SystemExit(
            'create_oi_ros needs the messages of its package msg_defs, which are not built: '
            '`colcon build --base-paths src/create_oi_ros src/create_oi_ros/msg_defs`, then '
            '`source install/setup.bash`') from None


def create_calibrate() -> int:
    """Work out the parameters of the odometry."""
    with _loading():
        from ..apps.calibrate.create_calibrate import main
    return main()


def create_demo() -> int:
    """Let a simulated robot show itself, and report on it."""
    with _loading():
        from ..apps.demo.create_demo import main
    return main()


def create_node() -> int:
    """Run the driver."""
    with _loading():
        from .node import main
    return main()


def create_record() -> int:
    """Record what a robot does to a bag."""
    with _loading():
        from ..apps.record.create_record import main
    return main()


def create_report() -> int:
    """Show on one page what a robot did, from a bag."""
    with _loading():
        from ..apps.report.create_report import main
    return main()


def create_run() -> int:
    """Run a robot, its driver and a status line."""
    with _loading():
        from ..apps.run import main
    return main()


def create_sim() -> int:
    """Run a simulated robot."""
    with _loading():
        from ..sim.server import main
    return main()


def create_view() -> int:
    """See a robot, and drive it, in a terminal."""
    with _loading():
        from ..apps.view.create_view import main
    return main()


PROGRAMS = {
    program.__name__: f'from {__name__} import {program.__name__} as run; raise SystemExit(run())'
    for program in (
        create_calibrate, create_demo, create_node, create_record, create_report, create_run,
        create_sim, create_view)}
"""Python that runs an executable wherever this package can be imported, installed or not."""
