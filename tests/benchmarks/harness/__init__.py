"""What makes the tables of this repository: nothing that a user of roadmend needs.

The folder above is on the path of whoever imports this: tests/benchmarks/bench.py and its workers, and the tests.
"""
