"""`create_calibrate listen`: distance and angle since the start, as `odom` reports them."""

from math import degrees, pi

from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.task import Future

from ...ros.process import call_on_signal, ros_executor, spin_until
from ...ros.rotation import yaw_of


class Tally:
    """Adds up distance and angle; the angle may exceed a full turn."""

    def __init__(self) -> None:
        self.distance = 0.0
        """Metres, forward less backward."""
        self.turned = 0.0
        """Radians, counter-clockwise."""
        self._before: tuple[float, float, float] | None = None

    def add(self, x: float, y: float, yaw: float, *, forward: bool) -> None:
        """Add the motion since the last pose."""
        if self._before is not None:
            x0, y0, yaw0 = self._before
            step = ((x - x0) ** 2 + (y - y0) ** 2) ** 0.5
            self.distance += step if forward else -step
            self.turned += (yaw - yaw0 + pi) % (2 * pi) - pi
        self._before = (x, y, yaw)


class _Listener(Node):

    def __init__(self, tally: Tally) -> None:
        super().__init__('create_calibrate')
        self._tally = tally
        self.create_subscription(Odometry, 'odom', self._on_odom, 100)
        self.create_timer(0.5, self._print)

    def _on_odom(self, odom: Odometry) -> None:
        pose = odom.pose.pose
        self._tally.add(
            pose.position.x, pose.position.y, yaw_of(pose.orientation),
            forward=odom.twist.twist.linear.x >= 0)

    def _print(self) -> None:
        print(f'\rreported: {self._tally.distance:+8.3f} m  {degrees(self._tally.turned):+9.1f} '
              'degrees   (Ctrl-C ends)', end='', flush=True)


def listen() -> int:
    """Print the tally until Ctrl-C."""
    ended = Future()
    call_on_signal(lambda: ended.set_result(0))
    with ros_executor() as executor:
        executor.add_node(_Listener(Tally()))
        spin_until(executor, ended)
        print()
    return 0
