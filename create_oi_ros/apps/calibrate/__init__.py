"""`create_calibrate`: computes the parameters of the odometry from measured drives."""
