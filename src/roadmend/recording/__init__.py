"""MCAP writing and reading."""
