"""MCAP writing and reading: bags that rosbag2, Foxglove, rosbags and the MCAP libraries of other languages open."""
