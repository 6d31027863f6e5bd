"""What `benchmarks/teacher.py` runs and shows."""
