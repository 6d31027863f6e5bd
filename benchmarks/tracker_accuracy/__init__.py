"""The accuracy and speed of the tracker, measured by `benchmarks/tracker.py`."""
