"""Code that tests share: simulated robots, ROS processes, terminals, bags, documentation pages."""
