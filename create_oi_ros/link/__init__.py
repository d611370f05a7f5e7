"""Bytes to and from the world: serial port, session thread, dead-man, capture. No ROS."""
