"""The ROS side: node, parameters, topics, services, diagnostics; how programs start and end."""
