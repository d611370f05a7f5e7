"""What tests share: simulated robots, ROS scenes, terminals, bags, pages."""
