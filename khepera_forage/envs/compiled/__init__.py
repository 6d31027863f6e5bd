"""The task in compiled worlds, one or thousands. Needs numba.

`worlds` has the records of a world, `step` is one round of it, `batch` steps many.
"""
