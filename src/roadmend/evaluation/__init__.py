"""Metrics, benchmark tables and pictures."""
