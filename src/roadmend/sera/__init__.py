"""SERA: a bank of scenarios, and what to take from it to learn from failures."""
