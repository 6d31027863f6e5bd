"""Many episodes: recall and training, one at a time in Python or thousands at once in compiled kernels."""
