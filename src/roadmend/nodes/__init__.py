"""ROS 2 nodes: thin shells around the core, and the launcher that starts them."""
