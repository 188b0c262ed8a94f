"""Scenarios, road networks, SUMO, the ego's dynamics, collisions and the episode runner."""
