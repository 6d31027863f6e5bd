"""The forages and the page of `benchmarks/teacher.py`."""
