"""Search for violations: points of a family's parameter space at which a policy collides by its own fault."""
