"""The rooms of `benchmarks/learners.py`."""
