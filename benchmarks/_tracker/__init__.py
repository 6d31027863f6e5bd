"""What `benchmarks/tracker.py` runs and shows."""
