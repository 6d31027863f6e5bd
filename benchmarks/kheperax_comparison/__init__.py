"""The comparison with Kheperax by `benchmarks/kheperax.py`."""
