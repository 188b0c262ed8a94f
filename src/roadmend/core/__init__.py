"""Types shared by every room: what a scene, a route, a command and a repair are. Knows no ROS, no SUMO."""
