"""The comparison of all learners by `benchmarks/learners.py`."""
