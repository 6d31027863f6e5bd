"""Rollouts of training and recall episodes: one at a time in Python, or thousands at once in compiled kernels."""
