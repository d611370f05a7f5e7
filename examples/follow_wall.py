"""
Follow a wall on the right: go ahead until something is touched, then along it.

    python examples/follow_wall.py
    python examples/follow_wall.py --ros-args -p signal:=250.0

`signal` is what the wall sensor is to say: the stronger, the nearer. The default suits the
simulator; for a real wall put the robot beside it and read topic `wall`. The program ends when
the robot leaves Safe mode: at a cliff, lifted, or on a charger.
"""
from math import sqrt
import signal

from create_oi_msgs.msg import Bumper, Mode, Wall
from geometry_msgs.msg import Twist, Vector3
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions

SIGNAL = 500.0
PERIOD = 0.05
"""Seconds between two commands."""
SPEED, GAIN, SHARPEST = 0.2, 3.0, 0.8
"""m/s; rad/s for an error of 1; rad/s, so that the robot rounds a corner in an arc."""
AWAY = ((-0.1, 0.0),) * 6 + ((0.0, 1.2),) * 12
"""After a touch, period by period: m/s and rad/s, back a little, then to the left."""


class Steering:
    """What to do next, from what the robot feels and sees."""

    def __init__(self, wanted: float = SIGNAL) -> None:
        self.wanted = wanted
        self.found = False  # whether there was a wall already
        self.away: list[tuple[float, float]] = []

    def next_move(self, touched: bool, signal: int) -> tuple[float, float]:
        """Return the speed, m/s, and the turning speed, rad/s to the left."""
        if touched and not self.away:
            self.away = list(AWAY)
        self.found = self.found or touched or signal > 0
        if self.away:
            return self.away.pop(0)
        if signal == 0:  # look for a wall, or round the corner where it ended
            return SPEED, -SHARPEST if self.found else 0.0
        # Light fades with the square of the distance: above 0 is too far away.
        error = sqrt(self.wanted / signal) - 1.0
        return SPEED, max(-SHARPEST, min(SHARPEST, -GAIN * error))


class FollowWall(Node):
    """Listens to bumper and wall sensor, and commands a velocity each period."""

    def __init__(self) -> None:
        super().__init__('follow_wall')
        self.steering = Steering(self.declare_parameter('signal', SIGNAL).value)
        self.touched, self.signal, self.mode = False, 0, Mode.UNKNOWN
        self.ended, self.asked_to_end = rclpy.task.Future(), False
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(Bumper, 'bumper', self.on_bumper, 10)
        self.create_subscription(Wall, 'wall', self.on_wall, 10)
        self.create_subscription(Mode, 'mode', self.on_mode, latched)
        self.velocity = self.create_publisher(Twist, 'cmd_vel', 1)
        self.create_timer(PERIOD, self.drive)

    def on_bumper(self, bumper: Bumper) -> None:
        touched = bumper.left or bumper.right
        if touched and not self.touched:
            print('touched something: back, and to the left', flush=True)
        self.touched = touched

    def on_wall(self, wall: Wall) -> None:
        self.signal = wall.signal

    def on_mode(self, mode: Mode) -> None:
        # Not yet Safe is no reason to end: the first command brings it back.
        if self.mode == Mode.SAFE and mode.mode != Mode.SAFE:
            self.ended.set_result(f'the robot has left Safe mode, {mode.reason}')
        self.mode = mode.mode

    def on_ctrl_c(self, *_: object) -> None:
        self.asked_to_end = True  # heeded in the next period: a signal may come amid anything

    def drive(self) -> None:
        if self.asked_to_end:
            self.ended.set_result('Ctrl-C')
            return
        speed, turn = self.steering.next_move(self.touched, self.signal)
        self.velocity.publish(Twist(linear=Vector3(x=speed), angular=Vector3(z=turn)))


def main() -> None:
    # With rclpy's own handlers Ctrl-C would end ROS under the feet of whoever publishes.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = FollowWall()
    signal.signal(signal.SIGINT, node.on_ctrl_c)
    rclpy.spin_until_future_complete(node, node.ended)
    print(f'no more commands, the driver stops the wheels: {node.ended.result()}')


if __name__ == '__main__':
    main()
