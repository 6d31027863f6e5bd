"""The recalls and the page of `benchmarks/arenas.py`."""
