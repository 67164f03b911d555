"""Benchmarks: how fast and how accurate. `python -m benchmarks` runs them all."""
