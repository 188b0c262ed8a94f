"""Gathers data by running episodes, and trains policies and repair models on it."""
