"""The repair interface, the guard that every method runs behind, and the methods."""
