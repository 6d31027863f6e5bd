"""Compilation with numba (extra `fast`): decorators, cache key, threads and functions that only kernels need."""

from khepera_forage.extras import require

require("the backend 'compiled'", "fast")
