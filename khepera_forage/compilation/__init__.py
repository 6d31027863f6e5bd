"""How kernels are compiled and run: decorators, cache key, threads. Needs numba (extra `fast`)."""
