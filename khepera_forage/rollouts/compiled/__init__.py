"""Rollouts that run wholly in compiled kernels. Needs numba (extra `fast`)."""
