"""Language models: one interface, and the backends behind it."""
