"""Bodies that compiled functions move: the backend "compiled". Needs numba (extra `fast`)."""
