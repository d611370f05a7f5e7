"""`create_calibrate`: the odometry's parameters from what a tape measure says."""
