"""Parts of `benchmarks/wire.py`: virtual robots, slow and disturbed lines, and the ends of a process."""
