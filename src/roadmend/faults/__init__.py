"""Fault injection: the running graph is disturbed on purpose, and what came of it is judged from outside."""
