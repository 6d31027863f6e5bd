"""What `benchmarks/virtual_lab.py` runs and shows."""
