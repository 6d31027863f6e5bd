"""The measures of `benchmarks/throughput.py`."""
