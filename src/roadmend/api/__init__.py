"""The Python interface: what may be taken from ``roadmend`` itself, and is told on the page src/doc/python.md."""
