"""The agreement of the two backends, tested by `benchmarks/agreement.py`."""
