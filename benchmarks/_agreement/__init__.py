"""What `benchmarks/agreement.py` plays, compares and shows."""
