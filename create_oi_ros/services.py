"""The services, declared once: name, type, what they do."""

from dataclasses import dataclass

from create_oi_msgs.srv import SetMode
from std_srvs.srv import Trigger


@dataclass(frozen=True, kw_only=True)
class Service:
    """One service; the node has a method of the same name."""

    name: str
    type: type
    about: str


SERVICES = (
    Service(
        name='set_mode', type=SetMode,
        about='enter Passive (1), Safe (2) or Full (3); answers when the robot reports it'),
    Service(name='stop', type=Trigger, about='stop the wheels before anything else is sent'),
    Service(
        name='reset_odometry', type=Trigger, about='begin `odom` again where the robot is'),
)
