"""What `benchmarks/kheperax.py` compares: the same work for Kheperax and for `BatchWorld`."""
