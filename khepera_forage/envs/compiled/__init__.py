"""The task in compiled worlds, one or thousands. Needs numba.

`step` has the records of a world and one round of it, `batch` steps many.
"""
