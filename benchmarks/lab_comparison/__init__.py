"""The virtual laboratory compared with pymunk alone, and tested on disturbed lines, by `benchmarks/virtual_lab.py`."""
