"""What `benchmarks/operations.py` counts and measures."""
