"""The pages of `benchmarks/decisions.py`: which readings of the thesis its own tables support, and what follows."""
