"""How far learned foraging carries to other arenas, measured by `benchmarks/generalisation.py`."""
