"""What `benchmarks/further_work.py` runs and shows: one file an experiment, listed in `registry.py`."""
