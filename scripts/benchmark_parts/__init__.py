"""The parts of `scripts/benchmark.py`: the lanes, the solvers, the clock."""
