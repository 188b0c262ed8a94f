"""Repair of driving policies while they drive."""

__version__ = "0.1.0"
