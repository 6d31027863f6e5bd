"""The experiments of `benchmarks/further_work.py`."""
