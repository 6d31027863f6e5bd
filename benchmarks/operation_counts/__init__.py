"""The operations of a compiled step and the limits of the machine, measured by `benchmarks/operations.py`."""
