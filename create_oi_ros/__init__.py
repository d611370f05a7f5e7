"""A ROS 2 driver for the iRobot Create, and a simulated Create that speaks the same bytes."""

__version__ = '1.0.0'
