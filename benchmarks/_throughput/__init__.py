"""What `benchmarks/throughput.py` measures, one file a subject."""
