"""Thousands of simulated worlds at once: bodies and camera of one robot and its food each, no task.

Needs numba (the extra `fast`). `BatchWorld` is what to use; the other modules are what its kernel is made of.
"""

from khepera_forage.sim.compiled.world import BatchWorld

__all__ = ["BatchWorld"]
