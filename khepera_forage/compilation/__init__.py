"""Compilation with numba (extra `fast`): decorators, cache key, threads and functions that only kernels need."""
