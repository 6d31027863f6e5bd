"""Bodies that compiled functions move: the backend "compiled". Needs numba (extra `fast`).

Every function here is written for one world, in plain Python with scalars and records; `step.advance` is the round.
"""
